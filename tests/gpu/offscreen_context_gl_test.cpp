#include <epoxy/egl.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <thread>

#include "foreview/scene/camera_model.h"
#include "gpu/gl_test_fixture.h"

namespace foreview {
namespace {

TEST_F(GlTest, ContextIsCoreProfileOfAtLeastVersion45) {
  GLint major = 0, minor = 0, profile = 0;
  glGetIntegerv(GL_MAJOR_VERSION, &major);
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  EXPECT_GE(major * 10 + minor, 45);
  EXPECT_TRUE((profile & GL_CONTEXT_CORE_PROFILE_BIT) != 0);
  EXPECT_NE(context().renderer().find(", OpenGL 4."), std::string::npos) << context().renderer();
}

TEST_F(GlTest, ContextsAreToldOfResetsWhereTheDriverCanTell) {
  if (!epoxy_has_egl_extension(context().display(), "EGL_EXT_create_context_robustness")) {
    GTEST_SKIP() << "this driver cannot tell of the GPU's resets";
  }
  const auto strategy = [] {
    GLint value = 0;
    glGetIntegerv(GL_RESET_NOTIFICATION_STRATEGY, &value);
    return value;
  };
  EXPECT_EQ(strategy(), GL_LOSE_CONTEXT_ON_RESET);
  EXPECT_EQ(glGetGraphicsResetStatus(), static_cast<GLenum>(GL_NO_ERROR));
  OffscreenContext::Options options;
  options.share_display = context().display();
  options.share_context = context().context();
  const OffscreenContext other(options);
  EXPECT_EQ(strategy(), GL_LOSE_CONTEXT_ON_RESET);
}

TEST_F(GlTest, ContextStartsInTheAgreedState) {
  const OffscreenContext fresh;
  GLint value = 0;
  glGetIntegerv(GL_CLIP_DEPTH_MODE, &value);
  EXPECT_EQ(value, GL_ZERO_TO_ONE);
  glGetIntegerv(GL_CLIP_ORIGIN, &value);
  EXPECT_EQ(value, GL_LOWER_LEFT);
  glGetIntegerv(GL_DEPTH_FUNC, &value);
  EXPECT_EQ(value, GL_GREATER);
  glGetIntegerv(GL_FRONT_FACE, &value);
  EXPECT_EQ(value, GL_CW);
  glGetIntegerv(GL_PACK_ALIGNMENT, &value);
  EXPECT_EQ(value, 1);
  glGetIntegerv(GL_UNPACK_ALIGNMENT, &value);
  EXPECT_EQ(value, 1);
  GLdouble depth = 1;
  glGetDoublev(GL_DEPTH_CLEAR_VALUE, &depth);
  EXPECT_EQ(depth, 0.0);
  EXPECT_EQ(glIsEnabled(GL_DITHER), GL_FALSE);
}

TEST_F(GlTest, ObjectsAreSharedWithAContextOnAnotherThread) {
  const GlTexture texture = make_texture_2d(GL_RGBA8, 1, 1);
  const std::array<GLubyte, 4> colour{1, 2, 3, 4};
  glTextureSubImage2D(texture.id(), 0, 0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, colour.data());
  glFinish();
  OffscreenContext::Options options;
  options.share_display = context().display();
  options.share_context = context().context();
  std::array<GLubyte, 4> read{};
  std::thread([&] {
    const OffscreenContext other(options);
    glGetTextureImage(texture.id(), 0, GL_RGBA, GL_UNSIGNED_BYTE, sizeof read, read.data());
  }).join();
  EXPECT_EQ(read, colour);
}

TEST_F(GlTest, ContextsComeAndGoWithoutHarmToOthers) {
  { const OffscreenContext other; }
  context().make_current();
  GLint major = 0;
  glGetIntegerv(GL_MAJOR_VERSION, &major);
  EXPECT_EQ(major, 4);
}

TEST_F(GlTest, UnusableDeviceChoiceIsAnInputError) {
  for (const char* value : {"999", "-1", "one", "0x"}) {
    ::setenv("FOREVIEW_EGL_DEVICE", value, 1);
    EXPECT_THROW(const OffscreenContext other, InputError) << value;
  }
  ::unsetenv("FOREVIEW_EGL_DEVICE");
}

/// The agreement that all drawing rests on: clip_from_camera() puts pixel (u, v) on framebuffer coordinates (u, v),
/// nearer wins, and a polygon that is counter-clockwise on the picture is a front face.
TEST_F(GlTest, ProjectionPutsPicturesUpperRowFirst) {
  CameraModel camera;
  camera.width = 4;
  camera.height = 3;
  camera.focal_length = {4, 4};
  camera.principal_point = {2, 1.5};
  const glm::mat4 clip_from_camera(camera.clip_from_camera(0.1));
  const glm::vec3 ray(camera.ray_from_pixel({0.5, 0.5}));
  const glm::vec4 clip = clip_from_camera * glm::vec4(ray * 2.0F, 1.0F);
  EXPECT_NEAR((clip.x / clip.w + 1) / 2 * 4, 0.5, 1e-6);
  EXPECT_NEAR((clip.y / clip.w + 1) / 2 * 3, 0.5, 1e-6);
  EXPECT_NEAR(clip.z / clip.w, 0.1 / 2, 1e-6);
  // Right, then up on the picture: counter-clockwise for the eye. Its signed area in window coordinates is negative.
  const auto window = [&](double u, double v) {
    const glm::vec4 c = clip_from_camera * glm::vec4(glm::vec3(camera.ray_from_pixel({u, v})), 1.0F);
    return glm::vec2(c) / c.w;
  };
  const glm::vec2 a = window(1, 2), b = window(3, 2), c = window(3, 1);
  EXPECT_LT((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y), 0.0F);
}

TEST_F(GlTest, ErrorsAbortTheTestProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(glEnable(GL_TEXTURE_2D_ARRAY), ::testing::KilledBySignal(SIGABRT), "");
}

}  // namespace
}  // namespace foreview
