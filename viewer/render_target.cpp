#include "foreview/viewer/render_target.h"

#include <algorithm>
#include <string>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

GlTexture make_multisample_texture(GLenum format, int width, int height) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &id);
  GlTexture texture(id);
  glTextureStorage2DMultisample(id, AntialiasedTarget::kSamples, format, width, height, GL_TRUE);
  return texture;
}

}  // namespace

void AntialiasedTarget::resize(int width, int height, const char* what, int samples) {
  if (width == width_ && height == height_ && samples == samples_) return;
  GLint limit = 0, viewport_limit[2] = {0, 0};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport_limit);
  limit = std::min({limit, viewport_limit[0], viewport_limit[1]});
  if (width < 1 || height < 1 || width > limit || height > limit) {
    throw InputError(what, "a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                               " pixels cannot be drawn; expected 1 to " + std::to_string(limit) +
                               " pixels along each side, the driver's limit");
  }
  const auto make_texture = samples == 1 ? [](GLenum format, int w, int h) { return make_texture_2d(format, w, h); }
                                         : make_multisample_texture;
  colour_ = make_texture(GL_RGBA8, width, height);
  depth_ = make_texture(GL_DEPTH_COMPONENT32F, width, height);
  samples_framebuffer_ = make_framebuffer(colour_.id(), depth_.id());
  resolved_.reset();
  resolved_framebuffer_.reset();
  if (samples != 1) {
    resolved_ = make_texture_2d(GL_RGBA8, width, height);
    resolved_framebuffer_ = make_framebuffer(resolved_.id());
  }
  samples_ = samples;
  width_ = width;
  height_ = height;
}

GLuint AntialiasedTarget::resolve() {
  if (samples_ == 1) return samples_framebuffer_.id();
  glBlitNamedFramebuffer(samples_framebuffer_.id(), resolved_framebuffer_.id(), 0, 0, width_, height_, 0, 0, width_,
                         height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return resolved_framebuffer_.id();
}

cv::Mat AntialiasedTarget::read() {
  cv::Mat picture(height_, width_, CV_8UC3);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolve());
  glReadPixels(0, 0, width_, height_, GL_BGR, GL_UNSIGNED_BYTE, picture.data);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  return picture;
}

}  // namespace foreview
