// Built into the executable only with AddressSanitizer. The window's drivers are unloaded at exit; LeakSanitizer, which
// looks afterwards, could then no longer name the module that a block came from, nor match it with the suppressions.
extern "C" int dlclose(void* /*handle*/) {
  return 0;
}
