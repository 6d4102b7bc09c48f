#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/gpu/gl_objects.h"

namespace foreview {

/// A framebuffer for what lies at each pixel (PredictedView::draw_surface): colour attachments 0 polygon (R32I, -1
/// where nothing is), 1 inverse distance (R32F, 1/m), 2 provenance (R8UI), 3 time of capture (R32I, as
/// TextureStore::capture_times() has it). Row 0 is the picture's top. Needs a current context in every member.
class SurfaceTarget {
 public:
  void resize(int width, int height);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_.id(); }
  /// Nothing anywhere.
  void clear() const;

  // These wait for the GPU.
  [[nodiscard]] cv::Mat read_polygons() const;    ///< CV_32S
  [[nodiscard]] cv::Mat read_inverse_z() const;   ///< CV_32F
  [[nodiscard]] cv::Mat read_provenance() const;  ///< CV_8U

 private:
  [[nodiscard]] cv::Mat read(GLenum attachment, GLenum format, GLenum type, int cv_type) const;

  int width_ = 0, height_ = 0;
  GlTexture polygon_, inverse_z_, provenance_, captured_, depth_;
  GlFramebuffer framebuffer_;
};

}  // namespace foreview
