#include "foreview/viewer/surface_target.h"

#include <array>

#include "foreview/gpu/texture_sets.h"

namespace foreview {

void SurfaceTarget::resize(int width, int height) {
  if (width_ == width && height_ == height) return;
  polygon_ = make_texture_2d(GL_R32I, width, height);
  inverse_z_ = make_texture_2d(GL_R32F, width, height);
  provenance_ = make_texture_2d(GL_R8UI, width, height);
  captured_ = make_texture_2d(GL_R32I, width, height);
  depth_ = make_texture_2d(GL_DEPTH_COMPONENT32F, width, height);
  framebuffer_ = make_framebuffer(polygon_.id(), depth_.id());
  glNamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT1, inverse_z_.id(), 0);
  glNamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT2, provenance_.id(), 0);
  glNamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT3, captured_.id(), 0);
  constexpr std::array<GLenum, 4> kBuffers{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2,
                                           GL_COLOR_ATTACHMENT3};
  glNamedFramebufferDrawBuffers(framebuffer_.id(), 4, kBuffers.data());
  width_ = width;
  height_ = height;
}

void SurfaceTarget::clear() const {
  constexpr std::array<GLint, 4> kNoPolygon{-1, -1, -1, -1};
  constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 0};
  constexpr std::array<GLuint, 4> kNeverSeen{0, 0, 0, 0};
  constexpr std::array<GLint, 4> kNoTime{kNeverCaptured, kNeverCaptured, kNeverCaptured, kNeverCaptured};
  glClearNamedFramebufferiv(framebuffer_.id(), GL_COLOR, 0, kNoPolygon.data());
  glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 1, kNothing.data());
  glClearNamedFramebufferuiv(framebuffer_.id(), GL_COLOR, 2, kNeverSeen.data());
  glClearNamedFramebufferiv(framebuffer_.id(), GL_COLOR, 3, kNoTime.data());
  glClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, kNothing.data());
}

cv::Mat SurfaceTarget::read(GLenum attachment, GLenum format, GLenum type, int cv_type) const {
  cv::Mat result(height_, width_, cv_type);
  glNamedFramebufferReadBuffer(framebuffer_.id(), attachment);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
  glReadPixels(0, 0, width_, height_, format, type, result.data);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  return result;
}

cv::Mat SurfaceTarget::read_polygons() const {
  return read(GL_COLOR_ATTACHMENT0, GL_RED_INTEGER, GL_INT, CV_32S);
}
cv::Mat SurfaceTarget::read_inverse_z() const {
  return read(GL_COLOR_ATTACHMENT1, GL_RED, GL_FLOAT, CV_32F);
}
cv::Mat SurfaceTarget::read_provenance() const {
  return read(GL_COLOR_ATTACHMENT2, GL_RED_INTEGER, GL_UNSIGNED_BYTE, CV_8U);
}

}  // namespace foreview
