#include "foreview/viewer/frame_composer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace foreview {
namespace {

int panels(DisplayMode mode) {
  return mode == DisplayMode::both ? 2 : 1;
}

}  // namespace

FrameComposer::FrameComposer(Replayer& replayer, double near_plane)
    : replayer_(replayer),
      near_plane_(near_plane),
      picture_program_(make_program("fullscreen.vert.glsl", "view_picture.frag.glsl")),
      no_vertices_(GlVertexArray::create()),
      picture_sampler_(make_clamped_sampler(GL_LINEAR_MIPMAP_LINEAR)) {
  const CameraModel& camera = replayer_.operator_camera();
  const auto longest = static_cast<unsigned>(std::max(camera.width, camera.height));
  picture_ = make_texture_2d(GL_RGBA8, camera.width, camera.height, static_cast<int>(std::bit_width(longest)));
}

FrameComposer::Size FrameComposer::native_size(DisplayMode mode) const {
  return {panels(mode) * replayer_.operator_camera().width, replayer_.operator_camera().height};
}

FrameComposer::Size FrameComposer::fitting_size(DisplayMode mode, int width, int height) const {
  const Size native = native_size(mode);
  const double scale = std::min(static_cast<double>(width) / native.width, static_cast<double>(height) / native.height);
  const auto scaled = [&](int length, int limit) {
    return std::clamp(static_cast<int>(std::lround(length * scale)), 1, std::max(limit, 1));
  };
  return {scaled(native.width, width), scaled(native.height, height)};
}

void FrameComposer::compose(Timestamp t, const DisplayChoice& choice, const Size& size) {
  target_.resize(size.width, size.height, "window");
  constexpr std::array<GLfloat, 4> kBlack{0, 0, 0, 1};
  glClearNamedFramebufferfv(target_.framebuffer(), GL_COLOR, 0, kBlack.data());
  const int left_width = size.width / panels(choice.mode);
  const PredictedView::Viewport left{0, 0, left_width, size.height};
  const PredictedView::Viewport right{left_width, 0, size.width - left_width, size.height};
  if (choice.mode != DisplayMode::delayed) draw_predicted(t, choice, left);
  if (choice.mode == DisplayMode::delayed) draw_delayed(choice, left);
  if (choice.mode == DisplayMode::both) draw_delayed(choice, right);
}

void FrameComposer::draw_predicted(Timestamp t, const DisplayChoice& choice, const PredictedView::Viewport& viewport) {
  const std::optional<PredictedState> state = replayer_.predicted_state(t);
  if (!state) return;
  ViewStyle style;
  style.holes_pink = choice.holes_pink;
  style.wireframe = choice.wireframe;
  style.near_plane = near_plane_;
  replayer_.view().draw(replayer_.operator_camera(), *state, style, target_.framebuffer(), viewport, false);
}

void FrameComposer::load_delayed_picture() {
  const std::optional<std::size_t> newest = replayer_.newest_used();
  if (newest == picture_index_) return;
  picture_index_ = newest;
  if (!newest) return;
  const cv::Mat picture = replayer_.undistorted_picture(*newest);
  glTextureSubImage2D(picture_.id(), 0, 0, 0, picture.cols, picture.rows, GL_BGR, GL_UNSIGNED_BYTE, picture.data);
  glGenerateTextureMipmap(picture_.id());
}

void FrameComposer::draw_delayed(const DisplayChoice& choice, const PredictedView::Viewport& viewport) {
  load_delayed_picture();
  if (!picture_index_) return;
  glBindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
  glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
  glUseProgram(picture_program_.id());
  glBindVertexArray(no_vertices_.id());
  glBindTextureUnit(0, picture_.id());
  glBindSampler(0, picture_sampler_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindSampler(0, 0);
  glBindVertexArray(0);
  glUseProgram(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (!choice.model_edges) return;
  Recording& recording = replayer_.recording();
  const Timestamp stamp = recording.cameras()[replayer_.camera()].pictures[*picture_index_].stamp;
  const std::optional<CaptureState> state = recording.capture_state(replayer_.camera(), stamp, replayer_.model());
  if (state)
    replayer_.view().draw_edges(replayer_.operator_camera(), *state, target_.framebuffer(), viewport, false,
                                near_plane_);
}

}  // namespace foreview
