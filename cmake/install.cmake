# `cmake --install` gives a library that find_package(foreview) finds, and the executable.
include(CMakePackageConfigHelpers)
get_property(rooms GLOBAL PROPERTY FOREVIEW_ROOMS)
foreach(room ${rooms})
  install(TARGETS foreview_${room} EXPORT foreview-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/foreview/${room}
          FILES_MATCHING PATTERN "*.h")
endforeach()
install(EXPORT foreview-targets NAMESPACE foreview:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/foreview)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/foreview-config.cmake.in
                              ${PROJECT_BINARY_DIR}/foreview-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/foreview)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/foreview-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/foreview-config.cmake ${PROJECT_BINARY_DIR}/foreview-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/foreview)
