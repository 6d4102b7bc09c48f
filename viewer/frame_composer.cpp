#include "foreview/viewer/frame_composer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "foreview/viewer/operator_camera.h"

namespace foreview {
namespace {

int panels(ViewMode mode) {
  return mode == ViewMode::side_by_side ? 2 : 1;
}

}  // namespace

FrameComposer::FrameComposer(PredictedView& view, const CameraModel& camera, double near_plane)
    : view_(view),
      camera_(camera.undistorted()),
      undistortion_(camera),
      near_plane_(near_plane),
      picture_program_(make_program("fullscreen.vert.glsl", "view_picture.frag.glsl")),
      no_vertices_(GlVertexArray::create()),
      picture_sampler_(make_clamped_sampler(GL_LINEAR_MIPMAP_LINEAR)) {
  const auto longest = static_cast<unsigned>(std::max(camera.width, camera.height));
  for (Shown* shown : {&delayed_, &truth_}) {
    shown->texture = make_texture_2d(GL_RGBA8, camera.width, camera.height, static_cast<int>(std::bit_width(longest)));
  }
}

FrameComposer::Size FrameComposer::native_size(ViewMode mode) const {
  return {panels(mode) * camera_.width, camera_.height};
}

FrameComposer::Size FrameComposer::fitting_size(ViewMode mode, int width, int height) const {
  const Size native = native_size(mode);
  const double scale = std::min(static_cast<double>(width) / native.width, static_cast<double>(height) / native.height);
  const auto scaled = [&](int length, int limit) {
    return std::clamp(static_cast<int>(std::lround(length * scale)), 1, std::max(limit, 1));
  };
  return {scaled(native.width, width), scaled(native.height, height)};
}

void FrameComposer::compose(const FrameInput& input, const ViewChoice& choice, const Size& size) {
  const bool fast = choice.quality == ViewQuality::fast;
  target_.resize(size.width, size.height, "window", fast ? 1 : AntialiasedTarget::kSamples);
  constexpr std::array<GLfloat, 4> kBlack{0, 0, 0, 1};
  glClearNamedFramebufferfv(target_.framebuffer(), GL_COLOR, 0, kBlack.data());
  const int left_width = size.width / panels(choice.mode);
  const int line = choice.mode == ViewMode::split
                       ? std::clamp(static_cast<int>(std::lround(choice.split * size.width)), 0, size.width)
                       : left_width;
  const Viewport left{0, 0, left_width, size.height, line};
  if (shows_predicted(choice.mode)) draw_predicted(input, choice, left);
  if (choice.mode == ViewMode::delayed) draw_delayed(input, choice, left, 0);
  if (choice.mode == ViewMode::side_by_side) {
    draw_delayed(input, choice, {left_width, 0, size.width - left_width, size.height}, left_width);
  }
  if (choice.mode == ViewMode::split) {
    draw_delayed(input, choice, {0, 0, left_width, size.height}, line);
  }
}

void FrameComposer::draw_predicted(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport) {
  if (!input.predicted) return;
  const Overlays& overlays = choice.overlays;
  ViewStyle style;
  style.quality = choice.quality;
  style.near_plane = near_plane_;
  // A room seen from outside would be hidden by its own walls.
  style.cull_back_faces = choice.camera == CameraMode::overview;
  style.holes_pink = overlays.holes;
  style.never_seen = overlays.never_seen;
  style.age = overlays.age;
  style.density = overlays.density;
  style.wireframe = overlays.wireframe;
  style.polygon = choice.polygon;
  style.moment = input.moment;
  style.age_span = choice.age_span;
  if (overlays.cone && input.capture) {
    style.spotlight = &*input.capture;
    style.spotlight_camera = &camera_;
  }
  view_.draw(with_field_of_view(camera_, choice.field_of_view), *input.predicted, style, target_.framebuffer(),
             viewport, false);
}

bool FrameComposer::load(const FramePicture& picture, Shown& into) {
  if (picture.picture.empty()) return false;
  if (into.any && into.key == picture.key) return true;
  const cv::Mat straight = undistortion_.undistort(picture.picture);
  glTextureSubImage2D(into.texture.id(), 0, 0, 0, straight.cols, straight.rows, GL_BGR, GL_UNSIGNED_BYTE,
                      straight.data);
  glGenerateTextureMipmap(into.texture.id());
  into.key = picture.key;
  into.any = true;
  return true;
}

/// Only what lies at `left` or right of it.
void FrameComposer::draw_delayed(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport,
                                 int left) {
  const int right = viewport.x + viewport.width;
  if (left >= right || !load(input.delayed, delayed_)) return;
  glBindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
  glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
  glScissor(left, viewport.y, right - left, viewport.height);
  glEnable(GL_SCISSOR_TEST);
  glUseProgram(picture_program_.id());
  glBindVertexArray(no_vertices_.id());
  glBindTextureUnit(0, delayed_.texture.id());
  glBindSampler(0, picture_sampler_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindSampler(0, 0);
  glBindVertexArray(0);
  glUseProgram(0);
  glDisable(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (!choice.overlays.edges || !input.capture) return;
  view_.draw_edges(camera_, *input.capture, target_.framebuffer(), viewport, false, near_plane_);
}

}  // namespace foreview
