foreview_add_fuzzer(textures_fuzzer SOURCES textures_fuzzer.cpp LINKS foreview::gpu)
