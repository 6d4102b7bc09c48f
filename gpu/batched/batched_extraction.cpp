#include "foreview/gpu/batched/batched_extraction.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "foreview/gpu/batched/capture_marker.h"
#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/chart_pyramid.h"
#include "foreview/gpu/batched/chart_tables.h"
#include "foreview/gpu/batched/exposure_estimator.h"
#include "foreview/gpu/batched/gatherer.h"
#include "foreview/gpu/batched/page_targets.h"
#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/batched/picture_bounds.h"
#include "foreview/gpu/batched/picture_setup.h"
#include "foreview/gpu/draw_tally.h"
#include "foreview/gpu/step_clock.h"
#include "foreview/gpu/timer_queries.h"
#include "foreview/gpu/undistorter.h"
#include "foreview/scene/errors.h"

namespace foreview {

using namespace batched;

namespace {

const ExtractionOptions& validated(const ExtractionOptions& options) {
  options.validate();
  if (options.artefacts != ArtefactSuppression::diamond && options.artefacts != ArtefactSuppression::none) {
    throw InputError("--artefacts",
                     "is a variant of the per-polygon pipeline only (--pipeline per-polygon); expected "
                     "diamond or none");
  }
  if (options.fill != HoleFilling::pyramid) {
    throw InputError("--fill",
                     "is a variant of the per-polygon pipeline only (--pipeline per-polygon); expected pyramid");
  }
  return options;
}

/// What all passes begin from, whatever was drawn before.
void set_up_passes() {
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  for (GLuint unit = 0; unit < 3; ++unit) glBindSampler(unit, 0);
}

}  // namespace

struct BatchedExtraction::State {
  State(TextureStore& store_, const ExtractionOptions& options_)
      : store(store_),
        options(validated(options_)),
        geometry(store.model(), store.layout()),
        tables(store.layout(), geometry),
        setup(store.model(), store.layout(), geometry),
        bounds(geometry),
        patches(geometry, tables, store.layout().page_size),
        pages(store),
        gatherer(geometry, store.layout()),
        marker(store.model(), store.layout(), geometry),
        pyramid(store, tables, patches, pages),
        newest(store.layout().groups.size()),
        is_late(store.layout().groups.size()),
        all_charts(store.layout().groups.size()) {
    std::iota(all_charts.begin(), all_charts.end(), 0U);
    if (options.compensate_exposure) exposure.emplace(store.model(), store.layout(), geometry);
  }

  /// Which of the picture's charts have been written from a newer one; of the others it is the newest from now on.
  void compare_stamps(Timestamp stamp) {
    is_late_for_all = newest_of_all && stamp < *newest_of_all;
    if (!is_late_for_all) newest_of_all = stamp;
    for (const std::uint32_t chart : setup.charts()) {
      is_late[chart] = newest[chart] && stamp < *newest[chart];
      if (!is_late[chart]) newest[chart] = stamp;
    }
  }

  /// All that was seen, but for the store's pages.
  void forget() {
    pyramid.clear();
    patches.clear();
    std::ranges::fill(newest, std::nullopt);
    newest_of_all.reset();
    if (exposure) exposure->clear();
  }

  TextureStore& store;
  ExtractionOptions options;
  ChartGeometry geometry;
  ChartTables tables;
  PictureSetup setup;
  Undistorter undistorter;
  PictureBounds bounds;
  PatchLists patches;
  PageTargets pages;
  Gatherer gatherer;
  CaptureMarker marker;
  ChartPyramid pyramid;
  std::optional<ExposureEstimator> exposure;  ///< none: off
  std::optional<Timestamp> newest_of_all;
  bool is_late_for_all = false;
  std::vector<std::optional<Timestamp>> newest;  ///< by chart
  std::vector<bool> is_late;                     ///< by chart, of the current picture
  std::vector<std::uint32_t> touched;            ///< polygons
  std::vector<std::uint32_t> all_charts;
  bool fill_all = false;  ///< with the next picture: charts hold what others made
  CameraModel last_camera;
  TimerQueries timer_queries;
  ExtractionTiming timing = ExtractionTiming::off;
  bool counting = false;
};

BatchedExtraction::BatchedExtraction(TextureStore& store, const ExtractionOptions& options)
    : state_(std::make_unique<State>(store, options)) {}
BatchedExtraction::~BatchedExtraction() = default;

ExtractionStatistics BatchedExtraction::extract(const CameraFrame& frame) {
  State& s = *state_;
  const CameraModel& camera = frame.camera;
  const double near_plane = s.options.near_plane;
  ExtractionStatistics statistics;
  StepClock clock(s.timing, &s.timer_queries);
  check_frame(frame, s.store.model());
  const DrawTally tally_before = draw_tally();
  s.undistorter.load(frame.picture, camera, name_of(frame));
  clock.lap(ExtractionStep::upload);
  s.store.wait_for_free_set();
  static_cast<void>(s.store.begin_picture());
  clock.lap(ExtractionStep::publishing);

  s.setup.prepare(camera, frame.state, near_plane);
  s.compare_stamps(frame.state.stamp);
  s.setup.bind();
  set_up_passes();
  clock.lap(ExtractionStep::projection);

  s.bounds.make_room(camera.width, camera.height);
  s.bounds.draw_surfaces(s.setup, camera, near_plane);
  clock.lap(ExtractionStep::occlusion);
  const bool suppressing = s.options.artefacts != ArtefactSuppression::none && s.options.passes > 0;
  if (suppressing) s.bounds.spread_rims(camera, s.options.passes);
  clock.lap(ExtractionStep::suppression);
  s.bounds.bound_cells(camera, suppressing, camera.is_distorted() ? s.undistorter.texture() : 0);
  const std::vector<std::uint32_t>& charts = s.fill_all ? s.all_charts : s.setup.charts();
  if (camera.width > 1 && camera.height > 1) s.fill_all = false;
  s.patches.touch(s.setup, charts, camera, near_plane, s.bounds);
  clock.lap(ExtractionStep::occlusion);
  if (s.exposure) {
    s.exposure->estimate(camera, near_plane, s.undistorter.texture(), s.bounds, s.patches,
                         s.pyramid.observed(ExposureEstimator::kLevel), s.store.exposure(), s.is_late_for_all);
    clock.lap(ExtractionStep::other);
  }
  s.gatherer.gather(s.setup, s.is_late, camera, near_plane, s.undistorter.texture(), s.store.exposure(), s.bounds,
                    s.patches, s.pages.level(0).targets);
  s.marker.mark(s.store.capture_times(), s.store.capture_time_of(frame.state.stamp), s.setup, s.is_late, camera,
                near_plane, s.bounds, s.patches);
  clock.lap(ExtractionStep::normalisation);
  s.pyramid.pull(charts);
  s.pyramid.push();
  clock.lap(ExtractionStep::filling);
  s.pyramid.write_states(s.store.polygon_states());
  // Far cheaper than it would be for every picture, where most of the model has never been seen.
  if (s.patches.picture_number() % BatchedExtraction::kSpreadEvery == 1) {
    s.store.spread_to_never_seen(TextureStore::kRimsPerPicture);
  }
  clock.lap(ExtractionStep::other);

  s.touched.clear();
  for (const std::uint32_t chart : charts) {
    const auto members = s.store.layout().members_of(s.store.layout().groups[chart]);
    s.touched.insert(s.touched.end(), members.begin(), members.end());
  }
  s.store.end_picture(s.touched, frame.state.stamp);
  clock.lap(ExtractionStep::publishing);
  s.last_camera = camera;

  statistics.polygons_visible = s.setup.visible().size();
  statistics.polygons_skipped_back_face = s.setup.back_faces();
  statistics.polygons_skipped_outside = s.setup.outside();
  statistics.charts_touched = s.setup.charts().size();
  statistics.texels_written = s.gatherer.texels();
  statistics.draw_calls = draw_tally().draw_calls - tally_before.draw_calls;
  statistics.passes = draw_tally().passes - tally_before.passes;
  clock.report(statistics);
  if (s.counting) {
    const auto lengths = s.patches.lengths();
    statistics.texels_filled = lengths[PatchLists::renewed] * kPatchTexels * kPatchTexels;
    statistics.texels_written =
        std::min(statistics.texels_written, lengths[PatchLists::touched] * std::size_t{kPatchTexels} * kPatchTexels);
    statistics.texels_observed = s.gatherer.observed();
  }
  return statistics;
}

void BatchedExtraction::begin(CameraFrame frame) {
  check_frame(frame, state_->store.model());
  Undistorter::check(frame.picture, frame.camera, name_of(frame));
  ExtractionPipeline::begin(std::move(frame));
}

std::optional<ExtractionSlice> BatchedExtraction::pending_slice() {
  if (is_busy() && !state_->store.has_free_set()) return std::nullopt;
  return ExtractionPipeline::pending_slice();
}

void BatchedExtraction::clear() {
  abandon_whole_picture();
  State& s = *state_;
  s.store.clear();
  s.forget();
  s.fill_all = false;
}

void BatchedExtraction::adopt_store() {
  abandon_whole_picture();
  State& s = *state_;
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  set_up_passes();
  // Nothing of what was seen before may stay. The pages, which the display may be reading, stay as they are until the
  // next picture.
  s.forget();
  s.patches.touch_all();
  s.pyramid.pull(s.all_charts, ChartPyramid::Pull::leave_pages);
  s.fill_all = true;
}

void BatchedExtraction::set_timing(ExtractionTiming timing) {
  state_->timing = timing;
}

void BatchedExtraction::set_counting(bool on) {
  state_->counting = on;
  state_->gatherer.set_counting(on);
}

BatchedExtraction::Intermediate BatchedExtraction::intermediate() const {
  const State& s = *state_;
  const int width = s.last_camera.width, height = s.last_camera.height;
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
  return {s.bounds.read_surfaces(width, height), s.bounds.read_unsafe(width, height),
          s.bounds.read_cells(width, height), s.undistorter.read()};
}

std::vector<cv::Mat> BatchedExtraction::pulled(int level) const {
  return state_->pyramid.read_pulled(level);
}

}  // namespace foreview
