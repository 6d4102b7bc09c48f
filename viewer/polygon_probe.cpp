#include "foreview/viewer/polygon_probe.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <utility>

#include "foreview/gpu/texture_store.h"
#include "foreview/viewer/operator_camera.h"
#include "foreview/viewer/view_geometry.h"

namespace foreview {
namespace {

/// As the pixel buffer holds them.
struct PixelAnswer {
  std::int32_t polygon = -1;
  float inverse_z = 0;
  std::int32_t captured = 0;
  std::uint32_t provenance = 0;
};

}  // namespace

PolygonProbe::PolygonProbe(PredictedView& view, const CameraModel& camera, double near_plane)
    : view_(view), camera_(camera.undistorted()), near_plane_(near_plane), pixel_buffer_(GlBuffer::create()) {
  target_.resize(1, 1);
  glNamedBufferStorage(pixel_buffer_.id(), sizeof(PixelAnswer), nullptr, 0);
}

void PolygonProbe::update(const FrameInput& input, const ViewChoice& choice, const FrameComposer::Size& size,
                          std::optional<glm::dvec2> cursor) {
  const PredictedView::Viewport viewport = FrameComposer::predicted_viewport(choice, size);
  const glm::ivec2 pixel = cursor ? glm::ivec2(glm::floor(*cursor)) : glm::ivec2(-1);
  over_view_ = cursor && input.predicted && shows_predicted(choice.mode) && pixel.x >= viewport.first_x() &&
               pixel.x < viewport.end_x() && pixel.y >= viewport.y && pixel.y < viewport.y + viewport.height;
  if (!over_view_) {
    found_.reset();
    report_.reset();
  }
  take_pixel();
  take_texels();
  if (over_view_ && !pixel_question_) ask_pixel(input, choice, viewport, pixel);
  if (report_ && !texel_question_) ask_texels();
}

void PolygonProbe::ask_pixel(const FrameInput& input, const ViewChoice& choice, const PredictedView::Viewport& viewport,
                             const glm::ivec2& pixel) {
  const CameraModel whole =
      fit_camera(with_field_of_view(input.camera_or(camera_), choice.field_of_view), viewport.width, viewport.height);
  CameraModel camera = whole;
  camera.width = camera.height = 1;
  camera.principal_point -= glm::dvec2(pixel.x - viewport.x, pixel.y - viewport.y);
  ViewStyle style;
  style.near_plane = near_plane_;
  style.cull_back_faces = choice.camera == CameraMode::overview;
  view_.draw_surface(camera, *input.predicted, style, target_);
  const TextureStore& store = view_.store();
  PixelQuestion question;
  question.epoch = store.acquire().epoch;
  store.release();
  question.ray = camera.ray_from_pixel({0.5, 0.5});
  question.world_from_camera = input.predicted->world_from_camera;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target_.framebuffer());
  glBindBuffer(GL_PIXEL_PACK_BUFFER, pixel_buffer_.id());
  const auto read = [&](GLenum attachment, GLenum format, GLenum type, std::size_t offset) {
    glNamedFramebufferReadBuffer(target_.framebuffer(), attachment);
    glReadPixels(0, 0, 1, 1, format, type, reinterpret_cast<void*>(offset));  // NOLINT(performance-no-int-to-ptr)
  };
  read(GL_COLOR_ATTACHMENT0, GL_RED_INTEGER, GL_INT, offsetof(PixelAnswer, polygon));
  read(GL_COLOR_ATTACHMENT1, GL_RED, GL_FLOAT, offsetof(PixelAnswer, inverse_z));
  read(GL_COLOR_ATTACHMENT3, GL_RED_INTEGER, GL_INT, offsetof(PixelAnswer, captured));
  read(GL_COLOR_ATTACHMENT2, GL_RED_INTEGER, GL_UNSIGNED_INT, offsetof(PixelAnswer, provenance));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  question.fence = GlFence::insert();
  pixel_question_ = std::move(question);
}

void PolygonProbe::take_pixel() {
  if (!pixel_question_ || !pixel_question_->fence.has_passed()) return;
  const PixelQuestion question = *std::exchange(pixel_question_, std::nullopt);
  if (!over_view_) return;
  PixelAnswer answer;
  glGetNamedBufferSubData(pixel_buffer_.id(), 0, sizeof answer, &answer);
  if (answer.polygon < 0 || !(answer.inverse_z > 0)) {
    found_.reset();
    report_.reset();
    return;
  }
  Found found;
  found.polygon = static_cast<std::uint32_t>(answer.polygon);
  found.distance = 1.0 / static_cast<double>(answer.inverse_z);
  found.point_in_world = question.world_from_camera * (found.distance * question.ray);
  found.provenance = answer.provenance >= 2   ? Found::Provenance::observed
                     : answer.provenance == 1 ? Found::Provenance::filled
                                              : Found::Provenance::never_seen;
  if (answer.captured != kNeverCaptured) {
    found.captured = question.epoch + Duration{std::int64_t{answer.captured} * 1'000'000};
  }
  found_ = found;
  if (report_ && report_->polygon == found.polygon) return;
  const TextureStore& store = view_.store();
  report_ = describe_polygon(store.model(), store.layout(), found.polygon);
  counted_picture_.reset();
}

/// The polygon's texels and times of capture, where a picture has come since they were last asked for.
void PolygonProbe::ask_texels() {
  const TextureStore& store = view_.store();
  const TextureStore::Shown shown = store.acquire();
  if (counted_picture_ != shown.picture) {
    TexelQuestion question;
    question.polygon = report_->polygon;
    question.box = texel_box(store.model(), store.layout(), report_->polygon);
    question.epoch = shown.epoch;
    question.picture = shown.picture;
    const glm::ivec2 first_block = question.box.first / kChartAlignment;
    question.blocks = (question.box.first + question.box.size - 1) / kChartAlignment - first_block + 1;
    const auto texels = static_cast<std::size_t>(question.box.size.x) * static_cast<std::size_t>(question.box.size.y);
    const auto blocks = static_cast<std::size_t>(question.blocks.x) * static_cast<std::size_t>(question.blocks.y);
    question.times_offset = 4 * texels;
    const std::size_t bytes = 4 * (texels + blocks);
    if (bytes > texel_bytes_) {
      texel_buffer_ = GlBuffer::create();
      glNamedBufferStorage(texel_buffer_.id(), static_cast<GLsizeiptr>(bytes), nullptr, 0);
      texel_bytes_ = bytes;
    }
    const auto page = static_cast<GLint>(report_->page);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, texel_buffer_.id());
    glGetTextureSubImage(shown.pages, 0, question.box.first.x, question.box.first.y, page, question.box.size.x,
                         question.box.size.y, 1, GL_BGRA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(4 * texels), nullptr);
    // NOLINTNEXTLINE(performance-no-int-to-ptr)
    auto* const offset = reinterpret_cast<void*>(question.times_offset);
    glGetTextureSubImage(shown.capture_times, 0, first_block.x, first_block.y, page, question.blocks.x,
                         question.blocks.y, 1, GL_RED_INTEGER, GL_INT, static_cast<GLsizei>(4 * blocks), offset);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    question.fence = GlFence::insert();
    texel_question_ = std::move(question);
  }
  store.release();
}

void PolygonProbe::take_texels() {
  if (!texel_question_ || !texel_question_->fence.has_passed()) return;
  const TexelQuestion question = *std::exchange(texel_question_, std::nullopt);
  if (!report_ || report_->polygon != question.polygon) return;
  cv::Mat texels(question.box.size.y, question.box.size.x, CV_8UC4);
  cv::Mat times(question.blocks.y, question.blocks.x, CV_32S);
  glGetNamedBufferSubData(texel_buffer_.id(), 0, static_cast<GLsizeiptr>(question.times_offset), texels.data);
  glGetNamedBufferSubData(texel_buffer_.id(), static_cast<GLintptr>(question.times_offset),
                          static_cast<GLsizeiptr>(times.total() * times.elemSize()), times.data);
  const bool counted_before = counted_picture_.has_value();
  const std::optional<Timestamp> newest_before =
      report_->captures.empty() ? std::nullopt : std::optional(report_->captures.front().stamp);
  const TextureStore& store = view_.store();
  count_texels(*report_, store.model(), store.layout(), texels, times, question.epoch);
  counted_picture_ = question.picture;
  if (!counted_before || report_->captures.empty() || report_->captures.front().stamp == newest_before) return;
  auto& changed_by = report_->changed_by;
  changed_by.insert(changed_by.begin(), question.picture);
  if (changed_by.size() > PolygonReport::kMostCaptures) changed_by.pop_back();
}

}  // namespace foreview
