# A room is one top-level folder and one library of the same name. Its headers are reachable only as
# <foreview/ROOM/header.h> and only by targets that link to it: every room has an include directory of its own in the
# build tree, holding one symbolic link to the room. A wrong include therefore does not compile.

add_library(foreview_warnings INTERFACE)
target_compile_options(foreview_warnings INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
if(FOREVIEW_WERROR)
  target_compile_options(foreview_warnings INTERFACE -Werror)
endif()
if(FOREVIEW_SANITIZE)
  add_compile_options(-fsanitize=${FOREVIEW_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${FOREVIEW_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # The checks that sanitizers insert make GCC take members for uninitialised that are not (its manual says so).
    add_compile_options(-Wno-maybe-uninitialized)
  endif()
  if(NOT FOREVIEW_SANITIZE MATCHES "thread" AND NOT FOREVIEW_SANITIZE MATCHES "fuzzer")
    add_compile_options(-fno-sanitize-recover=all)
  endif()
endif()

# foreview_add_room(NAME [SOURCES file...] LINKS target... [PRIVATE_LINKS target...]). A room without sources keeps its
# place in the order of includes.
function(foreview_add_room NAME)
  cmake_parse_arguments(ROOM "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  set(include_root ${PROJECT_BINARY_DIR}/rooms/${NAME})
  file(MAKE_DIRECTORY ${include_root}/foreview)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${include_root}/foreview/${NAME} SYMBOLIC)
  if(ROOM_SOURCES)
    add_library(foreview_${NAME} STATIC ${ROOM_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(foreview_${NAME} PRIVATE ${ROOM_PRIVATE_LINKS} $<BUILD_INTERFACE:foreview_warnings>)
  else()
    add_library(foreview_${NAME} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(foreview::${NAME} ALIAS foreview_${NAME})
  set_target_properties(foreview_${NAME} PROPERTIES EXPORT_NAME ${NAME} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(foreview_${NAME} ${scope} cxx_std_20)
  target_include_directories(foreview_${NAME} ${scope} $<BUILD_INTERFACE:${include_root}>
                                                       $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(foreview_${NAME} ${scope} ${ROOM_LINKS})
  set_property(GLOBAL APPEND PROPERTY FOREVIEW_ROOMS ${NAME})
endfunction()
