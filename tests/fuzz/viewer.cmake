foreview_add_fuzzer(view_options_fuzzer SOURCES view_options_fuzzer.cpp LINKS foreview::viewer)
