#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/gpu/gl_objects.h"

namespace foreview {

/// An off-screen framebuffer with 4 samples a pixel (RGBA8, depth 32F) and its resolved picture. Row 0 is the picture's
/// top. Needs a current context in every member.
class AntialiasedTarget {
 public:
  /// Makes the target this large, if it is not already. Throws InputError beyond the driver's limit, naming `what`.
  void resize(int width, int height, const char* what);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint framebuffer() const { return samples_framebuffer_.id(); }
  /// Averages the samples into the framebuffer returned (one sample a pixel, colour only).
  GLuint resolve();
  /// resolve(), then reads it back: CV_8UC3 BGR.
  [[nodiscard]] cv::Mat read();

 private:
  int width_ = 0, height_ = 0;
  GlTexture samples_, depth_, resolved_;
  GlFramebuffer samples_framebuffer_, resolved_framebuffer_;
};

}  // namespace foreview
