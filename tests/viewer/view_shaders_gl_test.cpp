#include <gtest/gtest.h>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/offscreen_context.h"

namespace foreview {
namespace {

TEST(ViewShaders, Compile) {
  OffscreenContext context({.debug = true});
  install_debug_callback(true);
  EXPECT_NE(make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl").id(), 0U);
  EXPECT_NE(make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl", "#define SURFACE 1\n").id(), 0U);
  for (const char* defines : {"#define FAST 1\n", "#define OVERLAYS 1\n", "#define FAST 1\n#define OVERLAYS 1\n"}) {
    EXPECT_NE(make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl", defines).id(), 0U);
  }
  EXPECT_NE(make_program("view_frustum.vert.glsl", "view_wireframe.frag.glsl").id(), 0U);
  EXPECT_NE(make_program("view_wireframe.vert.glsl", "view_wireframe.frag.glsl").id(), 0U);
}

}  // namespace
}  // namespace foreview
