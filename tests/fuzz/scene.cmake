foreview_add_fuzzer(mesh_fuzzer SOURCES mesh_fuzzer.cpp LINKS foreview::scene)
