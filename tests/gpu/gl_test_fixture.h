#pragma once
#include <gtest/gtest.h>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"

namespace foreview {

/// Base of all tests that need OpenGL: one off-screen context per test program, made when first needed, whose errors
/// abort. A test fails where no context can be made (software rendering is enough), and where GL objects that it (or
/// the fixture derived from this) made are still alive when it is destroyed.
class GlTest : public ::testing::Test {
 public:
  GlTest(const GlTest&) = delete;
  GlTest& operator=(const GlTest&) = delete;
  ~GlTest() override {
    context().make_current();  // a test may have made, and destroyed, one of its own
    EXPECT_EQ(live_gl_objects(), live_before_) << "GL objects of this test are still alive";
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glUseProgram(0);
  }

 protected:
  /// Derived fixtures may use GL in their constructors. Where no context can be made, every test of the program fails.
  GlTest() {
    context().make_current();
    live_before_ = live_gl_objects();
  }
  [[nodiscard]] static OffscreenContext& context() {
    static OffscreenContext the_context(debug_options());
    static const bool callback_installed = (install_debug_callback(true), true);
    (void)callback_installed;
    return the_context;
  }

 private:
  static OffscreenContext::Options debug_options() {
    OffscreenContext::Options options;
    options.debug = true;
    return options;
  }
  long live_before_ = 0;
};

}  // namespace foreview
