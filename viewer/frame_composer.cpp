#include "foreview/viewer/frame_composer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "foreview/viewer/frame_annotations.h"
#include "foreview/viewer/operator_camera.h"

namespace foreview {
namespace {

constexpr float kDifferenceGain = 4;

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
      finish_program_(make_program("fullscreen.vert.glsl", "view_finish.frag.glsl")),
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

PredictedView::Viewport FrameComposer::predicted_viewport(const ViewChoice& choice, const Size& size) {
  Viewport viewport{0, 0, size.width / panels(choice.mode), size.height};
  if (choice.mode == ViewMode::split) {
    viewport.end_column = static_cast<int>(std::lround(std::clamp(choice.split, 0.0, 1.0) * size.width));
  }
  return viewport;
}

void FrameComposer::compose(const FrameInput& input, const ViewChoice& choice, const Size& size) {
  const bool fast = choice.quality == ViewQuality::fast;
  target_.resize(size.width, size.height, "window", fast ? 1 : AntialiasedTarget::kSamples);
  constexpr std::array<GLfloat, 4> kBlack{0, 0, 0, 1};
  glClearNamedFramebufferfv(target_.framebuffer(), GL_COLOR, 0, kBlack.data());
  const Viewport predicted = predicted_viewport(choice, size);
  Viewport delayed{0, 0, size.width, size.height};
  if (choice.mode == ViewMode::side_by_side) {
    delayed.x = predicted.width;
    delayed.width = size.width - predicted.width;
  }
  if (choice.mode == ViewMode::split) delayed.first_column = predicted.end_column;
  if (shows_predicted(choice.mode) && !predicted.is_empty()) {
    draw_predicted(input, choice, predicted);
    finish_predicted(input, choice, predicted);
  }
  if (shows_delayed(choice.mode) && !delayed.is_empty()) draw_delayed(input, choice, delayed);
  annotate(input, choice, predicted);
}

void FrameComposer::draw_predicted(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport) {
  if (!input.predicted) return;
  const CameraModel camera = input.camera_or(camera_);
  const Overlays& overlays = choice.overlays;
  ViewStyle style;
  style.gaps = gaps_to_fill(camera, camera_);
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
    style.spotlight_camera = &camera;
  }
  view_.draw(with_field_of_view(camera, choice.field_of_view), *input.predicted, style, target_.framebuffer(), viewport,
             false);
}

bool FrameComposer::load(const FramePicture& picture, Shown& into) {
  // One taken before the camera became another one.
  if (picture.picture.cols != camera_.width || picture.picture.rows != camera_.height) return false;
  if (into.any && into.key == picture.key) return true;
  const cv::Mat straight = undistortion_.undistort(picture.picture);
  glTextureSubImage2D(into.texture.id(), 0, 0, 0, straight.cols, straight.rows, GL_BGR, GL_UNSIGNED_BYTE,
                      straight.data);
  glGenerateTextureMipmap(into.texture.id());
  into.key = picture.key;
  into.any = true;
  return true;
}

void FrameComposer::draw_over(const GlProgram& program, const Viewport& viewport) {
  glBindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
  glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
  glScissor(viewport.first_x(), viewport.y, viewport.end_x() - viewport.first_x(), viewport.height);
  glEnable(GL_SCISSOR_TEST);
  glUseProgram(program.id());
  glBindVertexArray(no_vertices_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  glUseProgram(0);
  glDisable(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

/// Difference and staleness: most frames have neither, and are left as they are.
void FrameComposer::finish_predicted(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport) {
  const bool difference = choice.mode == ViewMode::difference && input.predicted && load(input.truth, truth_);
  const auto severity = static_cast<float>(input.staleness.severity);
  if (!difference && severity <= 0) return;
  const Size size{target_.width(), target_.height()};
  if (unfinished_size_ != size) {
    unfinished_ = make_texture_2d(GL_RGBA8, size.width, size.height);
    unfinished_size_ = size;
  }
  target_.resolve();
  glCopyImageSubData(target_.resolved_texture(), GL_TEXTURE_2D, 0, 0, 0, 0, unfinished_.id(), GL_TEXTURE_2D, 0, 0, 0, 0,
                     size.width, size.height, 1);
  glProgramUniform1f(finish_program_.id(), 0, difference ? kDifferenceGain : 0.0F);
  glProgramUniform1f(finish_program_.id(), 1, severity);
  glBindTextureUnit(0, unfinished_.id());
  glBindTextureUnit(1, truth_.texture.id());
  glBindSampler(1, picture_sampler_.id());
  draw_over(finish_program_, viewport);
  glBindSampler(1, 0);
}

void FrameComposer::annotate(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport) {
  const FrameArea frame{0, 0, target_.width(), target_.height()};
  const FrameArea view{viewport.x, viewport.y, viewport.end_x() - viewport.x, viewport.height};
  if (choice.mode == ViewMode::split) paint_split(painter_, frame, viewport.end_x());
  const bool beside = choice.mode == ViewMode::split || choice.mode == ViewMode::side_by_side;
  if (beside && (choice.camera != CameraMode::follow || choice.field_of_view) && !input.delayed.picture.empty()) {
    // Left as it came, it does not fit the view beside it: nobody shall look for why.
    const int end = view.x + view.width;
    paint_note(painter_, {end, 0, frame.width - end, frame.height}, "from the real camera");
  }
  if (shows_predicted(choice.mode)) {
    int place = 0;
    if (choice.overlays.density) paint_density_scale(painter_, view, place++);
    if (choice.overlays.age) paint_age_scale(painter_, view, choice.age_span, place);
    if (choice.mode == ViewMode::difference) {
      paint_note(painter_, view, input.truth.picture.empty() ? "no picture was taken from here" : "difference x 4");
    }
  }
  paint_staleness(painter_, frame, input.staleness);
  painter_.flush(target_.framebuffer(), frame.width, frame.height);
}

void FrameComposer::draw_delayed(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport) {
  if (!load(input.delayed, delayed_)) return;
  glBindTextureUnit(0, delayed_.texture.id());
  glBindSampler(0, picture_sampler_.id());
  draw_over(picture_program_, viewport);
  glBindSampler(0, 0);
  if (!choice.overlays.edges || !input.capture) return;
  view_.draw_edges(input.camera_or(camera_), *input.capture, target_.framebuffer(), viewport, false, near_plane_);
}

}  // namespace foreview
