#include "foreview/gpu/per_polygon/per_polygon_extraction.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/draw_tally.h"
#include "foreview/gpu/per_polygon/artefact_suppressor.h"
#include "foreview/gpu/per_polygon/chart_copier.h"
#include "foreview/gpu/per_polygon/depth_owner_pass.h"
#include "foreview/gpu/per_polygon/hole_filler.h"
#include "foreview/gpu/per_polygon/normaliser.h"
#include "foreview/gpu/per_polygon/occlusion_mask.h"
#include "foreview/gpu/per_polygon/picture_data.h"
#include "foreview/gpu/per_polygon/polygon_textures.h"
#include "foreview/gpu/step_clock.h"
#include "foreview/gpu/undistorter.h"
#include "foreview/scene/errors.h"

namespace foreview {

namespace {

using namespace per_polygon;

TextureStore& without_groups(TextureStore& store) {
  if (store.layout().groups.size() != store.layout().charts.size()) {
    throw InputError("texture layout",
                     "holds several polygons in one chart; the per-polygon pipeline needs ChartOptions::group_polygons "
                     "to be false");
  }
  return store;
}

const ExtractionOptions& validated(const ExtractionOptions& options) {
  options.validate();
  return options;
}

/// The upper left part of a GL_RGBA8 texture, CV_8UC4 BGRA.
cv::Mat read_colours(GLuint texture, int width, int height) {
  cv::Mat result(height, width, CV_8UC4);
  glGetTextureSubImage(texture, 0, 0, 0, 0, width, height, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                       static_cast<GLsizei>(result.total() * result.elemSize()), result.data);
  return result;
}

cv::Mat read_alpha(GLuint texture, int width, int height) {
  cv::Mat result(height, width, CV_32F);
  glGetTextureSubImage(texture, 0, 0, 0, 0, width, height, 1, GL_RED, GL_FLOAT,
                       static_cast<GLsizei>(result.total() * result.elemSize()), result.data);
  return result;
}

}  // namespace

struct PerPolygonExtraction::State {
  State(TextureStore& store_, const ChartOptions& chart_options, const ExtractionOptions& options_)
      : store(without_groups(store_)),
        options(validated(options_)),
        textures(store.model(), chart_options),
        newest(textures.size()),
        picture(store.model(), store.layout(), textures),
        scene(store.model()),
        suppressor(options),
        filler(options, store.model(), textures) {}

  /// Steps 0-2, for all polygons.
  void begin(const CameraFrame& frame, StepClock& clock);
  /// Steps 3 and 4. Returns the alpha of the box.
  GLuint judge(std::size_t slot);
  [[nodiscard]] bool is_suppressed(std::size_t slot) const {
    return picture.visible()[slot].shorter_side >= options.small_texture;
  }
  [[nodiscard]] bool is_late(std::uint32_t polygon, Timestamp stamp) const {
    return newest[polygon] && stamp < *newest[polygon];
  }

  TextureStore& store;
  ExtractionOptions options;
  PolygonTextures textures;
  std::vector<std::optional<Timestamp>> newest;  ///< of the pictures that a polygon's texture was made from
  Undistorter undistorter;
  PictureData picture;
  DepthOwnerPass scene;
  OcclusionMask mask;
  ArtefactSuppressor suppressor;
  Normaliser normaliser;
  HoleFiller filler;
  ChartCopier copier;
  ExtractionTiming timing = ExtractionTiming::off;
  TimerQueries timer_queries;
  bool counting = false;
};

void PerPolygonExtraction::State::begin(const CameraFrame& frame, StepClock& clock) {
  check_frame(frame, store.model());
  undistorter.load(frame.picture, frame.camera, name_of(frame));
  clock.lap(ExtractionStep::upload);
  picture.prepare(frame.camera, frame.state, options.near_plane);
  picture.bind();
  clock.lap(ExtractionStep::projection);
  scene.draw(picture, frame.camera, options.near_plane);
  suppressor.make_room(frame.camera.width, frame.camera.height);
  clock.lap(ExtractionStep::occlusion);
}

PerPolygonExtraction::PerPolygonExtraction(TextureStore& store, const ChartOptions& chart_options,
                                           const ExtractionOptions& options)
    : state_(std::make_unique<State>(store, chart_options, options)) {}

PerPolygonExtraction::~PerPolygonExtraction() = default;

ExtractionStatistics PerPolygonExtraction::extract(const CameraFrame& frame) {
  State& s = *state_;
  ExtractionStatistics statistics;
  StepClock clock(s.timing, &s.timer_queries);
  const DrawTally tally_before = draw_tally();
  s.begin(frame, clock);
  const std::vector<PictureData::Visible>& visible = s.picture.visible();
  statistics.polygons_visible = visible.size();
  statistics.polygons_skipped_back_face = s.picture.count(Fate::back_face);
  statistics.polygons_skipped_outside = s.picture.count(Fate::outside);
  statistics.polygons_skipped_too_small = s.picture.count(Fate::too_small);

  const GLuint undistorted = s.undistorter.texture();
  const bool suppressing = s.options.artefacts != ArtefactSuppression::none && s.options.passes > 0;
  std::vector<std::uint32_t> touched, current;
  s.store.wait_for_free_set();
  [[maybe_unused]] const bool begun = s.store.begin_picture();
  assert(begun);
  s.picture.bind();  // the store may have bound what it copied by
  clock.lap(ExtractionStep::publishing);
  for (std::size_t slot = 0; slot < visible.size(); ++slot) {
    const auto& [polygon, box, shorter_side, has_outline] = visible[slot];
    if (suppressing && !s.is_suppressed(slot)) ++statistics.polygons_exempt_small;
    if (!has_outline) continue;
    s.mask.judge(s.picture, slot, undistorted, s.scene, s.options.near_plane, s.suppressor.alpha());
    clock.lap(ExtractionStep::occlusion);
    const GLuint alpha = s.is_suppressed(slot) ? s.suppressor.suppress(box.width, box.height) : s.suppressor.alpha();
    clock.lap(ExtractionStep::suppression);
    const PolygonTextures::Item& own = s.textures[polygon];
    s.normaliser.fuse(slot, undistorted, alpha, s.options.near_plane, s.is_late(polygon, frame.state.stamp),
                      own.texture.id(), own.width, own.height);
    clock.lap(ExtractionStep::normalisation);
    s.filler.fill(own.texture.id(), polygon, s.store.polygon_states(), true);
    clock.lap(ExtractionStep::filling);
    s.copier.copy(s.picture, slot, s.filler.filled(), own.texture.id(), s.store);
    clock.lap(ExtractionStep::other);
    if (!s.is_late(polygon, frame.state.stamp)) {
      s.newest[polygon] = frame.state.stamp;
      current.push_back(polygon);
    }
    touched.push_back(polygon);
    const auto texels = static_cast<std::size_t>(own.width) * static_cast<std::size_t>(own.height);
    statistics.texels_written += texels;
    statistics.texels_filled += texels;
  }
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  if (!touched.empty()) {
    s.store.update_levels(touched);
    s.store.spread_to_never_seen(TextureStore::kRimsPerPicture);
  }
  clock.lap(ExtractionStep::other);
  s.store.set_capture_time(current, s.store.capture_time_of(frame.state.stamp));
  s.store.end_picture(touched, frame.state.stamp);
  clock.lap(ExtractionStep::publishing);
  statistics.charts_touched = touched.size();
  statistics.draw_calls = draw_tally().draw_calls - tally_before.draw_calls;
  statistics.passes = draw_tally().passes - tally_before.passes;
  if (s.counting) statistics.texels_observed = s.normaliser.take_count();
  clock.lap(ExtractionStep::other);
  clock.report(statistics);
  return statistics;
}

void PerPolygonExtraction::begin(CameraFrame frame) {
  check_frame(frame, state_->store.model());
  Undistorter::check(frame.picture, frame.camera, name_of(frame));
  ExtractionPipeline::begin(std::move(frame));
}

std::optional<ExtractionSlice> PerPolygonExtraction::pending_slice() {
  if (is_busy() && !state_->store.has_free_set()) return std::nullopt;
  return ExtractionPipeline::pending_slice();
}

void PerPolygonExtraction::clear() {
  abandon_whole_picture();
  state_->textures.clear();
  std::ranges::fill(state_->newest, std::nullopt);
  state_->store.clear();
}

void PerPolygonExtraction::adopt_store() {
  assert(!is_busy());
  State& s = *state_;
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  for (std::uint32_t i = 0; i < s.textures.size(); ++i) s.copier.adopt(s.store, i, s.textures[i]);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  std::ranges::fill(s.newest, std::nullopt);
}

void PerPolygonExtraction::set_timing(ExtractionTiming timing) {
  state_->timing = timing;
}

void PerPolygonExtraction::set_counting(bool on) {
  state_->counting = on;
  state_->normaliser.set_counting(on);
}

PerPolygonExtraction::Intermediate PerPolygonExtraction::inspect(const CameraFrame& frame, std::uint32_t polygon) {
  State& s = *state_;
  if (polygon >= s.textures.size()) {
    throw InputError("polygon " + std::to_string(polygon),
                     "is not in the model of " + std::to_string(s.textures.size()) + " polygons");
  }
  StepClock no_clock(ExtractionTiming::off);
  s.begin(frame, no_clock);
  const PolygonTextures::Item& own = s.textures[polygon];
  const int width = own.width, height = own.height;
  const GlTexture fused = make_texture_2d(GL_RGBA8, width, height);
  glCopyImageSubData(own.texture.id(), GL_TEXTURE_2D, 0, 0, 0, 0, fused.id(), GL_TEXTURE_2D, 0, 0, 0, 0, width, height,
                     1);

  Intermediate result;
  const std::vector<PictureData::Visible>& visible = s.picture.visible();
  const auto found = std::ranges::find(visible, polygon, &PictureData::Visible::polygon);
  if (found != visible.end()) {
    const auto slot = static_cast<std::size_t>(found - visible.begin());
    const PixelBox& box = found->box;
    result.box_x = box.x;
    result.box_y = box.y;
    s.mask.judge(s.picture, slot, s.undistorter.texture(), s.scene, s.options.near_plane, s.suppressor.alpha());
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    result.box_alpha_before = read_alpha(s.suppressor.alpha(), box.width, box.height);
    const GLuint alpha = s.is_suppressed(slot) ? s.suppressor.suppress(box.width, box.height) : s.suppressor.alpha();
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    result.box_alpha_after = read_alpha(alpha, box.width, box.height);
    s.normaliser.fuse(slot, s.undistorter.texture(), alpha, s.options.near_plane, s.is_late(polygon, frame.state.stamp),
                      fused.id(), width, height);
  }
  s.filler.fill(fused.id(), polygon, s.store.polygon_states(), false);
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
  result.fused = read_colours(fused.id(), width, height);
  result.filled = read_colours(s.filler.filled(), width, height);
  if (s.counting) static_cast<void>(s.normaliser.take_count());
  return result;
}

cv::Mat PerPolygonExtraction::undistorted(const CameraFrame& frame) {
  state_->undistorter.load(frame.picture, frame.camera);
  return state_->undistorter.read();
}

}  // namespace foreview
