foreview_add_fuzzer(measured_delays_fuzzer SOURCES measured_delays_fuzzer.cpp LINKS foreview::server)
foreview_add_fuzzer(raw_picture_fuzzer SOURCES raw_picture_fuzzer.cpp LINKS foreview::server opencv_core)
# From the bytes on the wire on: needs what the IDL compiler made.
foreview_add_fuzzer(live_messages_fuzzer SOURCES live_messages_fuzzer.cpp
                    LINKS foreview::server CycloneDDS::ddsc opencv_core
                    INCLUDES ${PROJECT_BINARY_DIR}/server/idl)
