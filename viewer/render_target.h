#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/gpu/gl_objects.h"

namespace foreview {

/// An off-screen framebuffer with several samples a pixel (RGBA8, depth 32F) and its resolved picture. Row 0 is the
/// picture's top. Needs a current context in every member.
class AntialiasedTarget {
 public:
  static constexpr int kSamples = 4;  ///< OpenGL 4.5 guarantees this many
  /// Makes the target this large, if it is not already, with kSamples or 1 sample a pixel. Throws InputError beyond the
  /// driver's limit, naming `what`.
  void resize(int width, int height, const char* what, int samples = kSamples);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint framebuffer() const { return samples_framebuffer_.id(); }
  /// Averages the samples into the framebuffer returned (one sample a pixel, colour only).
  GLuint resolve();
  /// What resolve() gives, as a texture.
  [[nodiscard]] GLuint resolved_texture() const { return samples_ == 1 ? colour_.id() : resolved_.id(); }
  /// resolve(), then reads it back: CV_8UC3 BGR.
  [[nodiscard]] cv::Mat read();

 private:
  int width_ = 0, height_ = 0, samples_ = 0;
  GlTexture colour_, depth_, resolved_;
  GlFramebuffer samples_framebuffer_, resolved_framebuffer_;
};

}  // namespace foreview
