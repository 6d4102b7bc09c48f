#include "foreview/viewer/display_errors.h"

#include <dlfcn.h>

#include <atomic>

namespace foreview {
namespace {

// Xlib is there only where GLFW uses it, so it is asked for at run time; these are its declarations, as far as needed.
struct XErrorEvent {
  int type;
  void* display;
  unsigned long resource;
  unsigned long serial;
  unsigned char error_code;
  unsigned char request_code;
  unsigned char minor_code;
};
using ErrorHandler = int (*)(void*, XErrorEvent*);
using IoErrorHandler = int (*)(void*);
using IoErrorExitHandler = void (*)(void*, void*);

constexpr unsigned char kBadWindow = 3, kBadDrawable = 9;

std::atomic<DisplayState> state{DisplayState::well};

int on_error(void* /*display*/, XErrorEvent* event) {
  const bool window = event->error_code == kBadWindow || event->error_code == kBadDrawable;
  DisplayState well = DisplayState::well;
  if (window) state.compare_exchange_strong(well, DisplayState::window_gone);
  return 0;
}

int on_io_error(void* /*display*/) {
  state = DisplayState::server_gone;
  return 0;
}

/// Returning from here lets Xlib's call return to its caller, instead of ending the process.
void on_io_error_exit(void* /*display*/, void* /*data*/) {}

struct Xlib {
  void* library = dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
  template <class Function>
  [[nodiscard]] Function find(const char* name) const {
    return library != nullptr ? reinterpret_cast<Function>(dlsym(library, name)) : nullptr;
  }
  ErrorHandler (*set_error_handler)(ErrorHandler) = find<ErrorHandler (*)(ErrorHandler)>("XSetErrorHandler");
  IoErrorHandler (*set_io_error_handler)(IoErrorHandler) =
      find<IoErrorHandler (*)(IoErrorHandler)>("XSetIOErrorHandler");
  // Since libX11 1.7; without it Xlib ends the process after on_io_error().
  void (*set_io_error_exit_handler)(void*, IoErrorExitHandler,
                                    void*) = find<void (*)(void*, IoErrorExitHandler, void*)>("XSetIOErrorExitHandler");
};

}  // namespace

void watch_display(void* native_display) {
  static const Xlib xlib;
  if (xlib.set_error_handler != nullptr) xlib.set_error_handler(on_error);
  if (xlib.set_io_error_handler != nullptr) xlib.set_io_error_handler(on_io_error);
  if (xlib.set_io_error_exit_handler != nullptr && native_display != nullptr) {
    xlib.set_io_error_exit_handler(native_display, on_io_error_exit, nullptr);
  }
}

DisplayState display_state() {
  return state;
}

}  // namespace foreview
