#include "foreview/gpu/batched/picture_work.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <utility>

#include "foreview/gpu/batched/batched_extraction.h"

namespace foreview::batched {
namespace {

// What a unit of each pass goes over.
constexpr std::size_t kUploadRows = 16, kRows = 8;
constexpr std::size_t kPolygons = 256;
constexpr std::size_t kCopyBytes = 300'000;  // as much as the largest command of PageCopier
constexpr std::size_t kCandidates = 64;      // a workgroup of the shaders that go over them
constexpr std::size_t kPatches = 16, kMarkGroups = 4;
constexpr std::size_t kCharts = 256;

/// Texels of a patch at a level.
constexpr double patch_texels(int level) {
  return static_cast<double>(kPatchTexels) * kPatchTexels / static_cast<double>(1 << 2 * level);
}

/// What all passes begin from, whatever was drawn before.
void set_up_passes() {
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_DEPTH_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  for (GLuint unit = 0; unit < 3; ++unit) glBindSampler(unit, 0);
}

std::size_t units_of(std::size_t total, std::size_t per_unit) {
  return (total + per_unit - 1) / per_unit;
}

// Sizes are what passes cost beside each other (as measured with llvmpipe), so that one cost for each kind is enough.
constexpr double kMega = 1e-6;
constexpr double kUploadWeight = 0.4, kClearWeight = 0.34, kSpreadWeight = 0.62, kSpreadTwiceWeight = 1.25;
constexpr double kCellsWeight = 1.36, kCoarseWeight = 0.19;
constexpr double kPulledPatch = 24, kPushedPatch = 38;  // texels: what a patch costs beside its own
constexpr double kBaseWeight = 0.6;                     // of texels at level 0 when pushing

}  // namespace

std::span<const SliceKind> PictureWork::kinds() {
  static constexpr std::array<SliceKind, kPhases> kKinds{{
      {"upload", ExtractionStep::upload, 0.1, 10, "megapixels"},
      {"polygons", ExtractionStep::projection, 0.01, 0.03, "thousand polygons"},
      {"surfaces", ExtractionStep::occlusion, 0.15, 9, "megapixels"},
      {"contours", ExtractionStep::suppression, 0.15, 10, "megapixels"},
      {"copy", ExtractionStep::publishing, 0.05, 0.1, "megabytes"},
      {"patches", ExtractionStep::occlusion, 0.05, 0.07, "thousand patches"},
      {"gather", ExtractionStep::normalisation, 0.15, 7.5, "megatexels"},
      {"pull", ExtractionStep::filling, 0.15, 12, "megatexels"},
      {"push", ExtractionStep::filling, 0.15, 8.5, "megatexels"},
      {"states", ExtractionStep::other, 0.05, 0.05, "thousand polygons"},
  }};
  return kKinds;
}

PictureWork::PictureWork(TextureStore& store, const ExtractionOptions& options)
    : store_(store),
      options_(options),
      geometry_(store.model(), store.layout()),
      tables_(store.layout(), geometry_),
      setup_(store.model(), store.layout(), geometry_),
      bounds_(geometry_),
      patches_(geometry_, tables_, store.layout().page_size),
      pages_(store),
      gatherer_(geometry_, store.layout()),
      marker_(store.model(), store.layout(), geometry_),
      pyramid_(store, tables_, patches_, pages_),
      newest_(store.layout().groups.size()),
      all_charts_(store.layout().groups.size()),
      is_late_(store.layout().groups.size()) {
  std::iota(all_charts_.begin(), all_charts_.end(), 0U);
  if (options_.compensate_exposure) exposure_.emplace(store.model(), store.layout(), geometry_);
}

int PictureWork::diamond_passes() const {
  return options_.artefacts != ArtefactSuppression::none ? options_.passes : 0;
}

void PictureWork::begin(CameraFrame frame, bool at_once) {
  frame_ = std::move(frame);
  at_once_ = at_once;
  fills_all_ = adopted_;
}

bool PictureWork::enter(Phase phase) {
  switch (phase) {
    case uploading:
      undistorter_.begin(frame_.picture, frame_.camera, name_of(frame_));
      break;
    case polygons:
      setup_.begin(frame_.camera, frame_.state, options_.near_plane);
      break;
    case surfaces:
      bounds_.make_room(frame_.camera.width, frame_.camera.height);
      break;
    case copying:
      if (!store_.begin_picture_in_pieces()) return false;
      break;
    case gathering:
    case pushing:
      if (!at_once_) lengths_ = patches_.fetched_lengths();
      break;
    default:
      break;
  }
  cursor_ = SliceCursor(passes_of(phase));
  // The first phases with passes that read what is bound here, after others that bind something else.
  if (phase == surfaces || phase == patches) resume();
  return true;
}

void PictureWork::resume() {
  set_up_passes();
  setup_.bind();
  patches_.bind();
}

void PictureWork::add_patch_passes(std::vector<Pass>& passes, PatchLists::List list, double texels) const {
  passes.push_back({ExtractionStep::filling, at_once_ ? 1 : units_of(lengths_[list], kPatches),
                    texels * static_cast<double>(kPatches) * kMega});
}

std::vector<Pass> PictureWork::passes_of(Phase phase) const {
  const auto width = static_cast<std::size_t>(frame_.camera.width);
  const auto height = static_cast<std::size_t>(frame_.camera.height);
  const bool has_cells = width > 1 && height > 1;
  const double row = static_cast<double>(width) * kMega;
  const double thousand_polygons = 1e-3 * static_cast<double>(setup_.polygons());
  const std::size_t candidates = patches_.candidate_count();
  std::vector<Pass> passes;
  switch (phase) {
    case uploading: {
      constexpr auto kStep = ExtractionStep::upload;
      passes.push_back({kStep, units_of(height, kUploadRows), kUploadWeight * row * kUploadRows});
      passes.push_back({kStep, frame_.camera.is_distorted() ? units_of(height, kRows) : 0, row * kRows});
      break;
    }
    case polygons: {
      constexpr auto kStep = ExtractionStep::projection;
      passes.push_back({kStep, units_of(setup_.polygons(), kPolygons), 1e-3 * kPolygons});
      passes.push_back({kStep, 1, 0.7 * thousand_polygons + 0.1});
      break;
    }
    case surfaces: {
      constexpr auto kStep = ExtractionStep::occlusion;
      passes.push_back({kStep, 1, kClearWeight * row * static_cast<double>(height)});
      passes.push_back({kStep, units_of(height, kRows), row * kRows});
      break;
    }
    case contours: {
      const int rims = diamond_passes() > 0 ? PictureBounds::rim_passes(diamond_passes()) : 0;
      for (int i = 0; i < rims; ++i) {
        const bool once = i == 1 && diamond_passes() % 2 == 1;
        const double weight = i == 0 ? 1 : once ? kSpreadWeight : kSpreadTwiceWeight;
        passes.push_back({ExtractionStep::suppression, units_of(height, kRows), weight * row * kRows});
      }
      passes.push_back(
          {ExtractionStep::occlusion, has_cells ? units_of(height - 1, kRows) : 0, kCellsWeight * row * kRows});
      const int coarse_rows = PictureBounds::coarse_rows(frame_.camera);
      passes.push_back({ExtractionStep::occlusion, has_cells ? static_cast<std::size_t>(coarse_rows) : 0,
                        kCoarseWeight * row * PictureBounds::kCoarse});
      break;
    }
    case copying:
      passes.push_back({ExtractionStep::publishing, units_of(store_.catch_up_left(), kCopyBytes), kMega * kCopyBytes});
      break;
    case patches: {
      const double unit = 1e-3 * kCandidates;
      std::size_t count = 0;
      for (const std::uint32_t chart : charts()) count += has_cells ? geometry_.patches_of(chart).count : 0;
      passes.push_back({ExtractionStep::occlusion, 1, 3e-5 * static_cast<double>(count) + 0.05});
      passes.push_back({ExtractionStep::occlusion, units_of(count, kCandidates), unit});
      passes.push_back({ExtractionStep::other, exposure_ ? units_of(count, kCandidates) : 0, 2.7 * unit});
      passes.push_back({ExtractionStep::other, exposure_ ? 1U : 0U, 0.8});
      passes.push_back({ExtractionStep::occlusion, at_once_ ? 0U : 1U, 0.2});
      break;
    }
    case gathering: {
      constexpr auto kStep = ExtractionStep::normalisation;
      const double unit = kMega * Gatherer::kTexelsPerUnit;
      const auto touched = at_once_ ? 0.0 : static_cast<double>(lengths_[PatchLists::touched]);
      passes.push_back({kStep, 1, 0.005 + 8e-6 * touched});
      // At most; exactly known once the list is made.
      passes.push_back({kStep, at_once_ ? 1 : gatherer_.most_units(patches_.fetched_touched()), unit});
      const std::size_t groups = units_of(lengths_[PatchLists::touched], PatchLists::kPatchesPerGroup);
      passes.push_back({kStep, at_once_ ? 1 : units_of(groups, kMarkGroups), 3.7e-4 * kMarkGroups});
      break;
    }
    case pulling: {
      constexpr auto kStep = ExtractionStep::filling;
      for (int level = 1; level <= ChartPyramid::kPatchLevels; ++level) {
        add_patch_passes(passes, PatchLists::touched, patch_texels(level) + kPulledPatch);
      }
      const int tips = pyramid_.tip_passes();
      for (int i = 0; i < tips; ++i) {
        // Of which the last writes into the pages' layout.
        passes.push_back({kStep, units_of(pyramid_.charts(), kCharts), i + 1 < tips ? 9e-3 : 3e-2});
      }
      passes.push_back({kStep, units_of(candidates, kCandidates), 4.3e-4});
      passes.push_back({kStep, at_once_ ? 0U : 1U, 1e-3});
      break;
    }
    case pushing:
      for (int level = ChartPyramid::kPatchLevels - 1; level >= 0; --level) {
        add_patch_passes(passes, level > 0 ? PatchLists::renewed : PatchLists::holed,
                         (level > 0 ? 1 : kBaseWeight) * patch_texels(level) + kPushedPatch);
      }
      break;
    case states: {
      constexpr auto kStep = ExtractionStep::other;
      passes.push_back({kStep, 1, thousand_polygons});
      // Far cheaper than it would be for every picture, where most of the model has never been seen.
      const bool spreads = patches_.picture_number() % BatchedExtraction::kSpreadEvery == 1;
      passes.push_back(
          {kStep, spreads ? TextureStore::spread_pieces(TextureStore::kRimsPerPicture) : 0, thousand_polygons});
      break;
    }
  }
  return passes;
}

Run PictureWork::things(const Run& units, std::size_t per_unit, std::size_t total) {
  const std::size_t first = units.first * per_unit;
  return {first, std::min(units.count * per_unit, total - first)};
}

std::optional<Run> PictureWork::listed(const Run& units, PatchLists::List list) const {
  if (at_once_) return std::nullopt;
  return things(units, kPatches, lengths_[list]);
}

void PictureWork::issue(Phase phase, const SliceCursor::Piece& piece) {
  const CameraModel& camera = frame_.camera;
  const auto height = static_cast<std::size_t>(camera.height);
  const auto rows_of = [](const Run& rows) {
    return PictureBounds::Rows{static_cast<int>(rows.first), static_cast<int>(rows.count)};
  };
  const auto& [pass, run, size] = piece;
  switch (phase) {
    case uploading: {
      const PictureBounds::Rows rows = rows_of(things(run, pass == 0 ? kUploadRows : kRows, height));
      if (pass == 0) {
        undistorter_.upload(frame_.picture, camera, rows.first, rows.count);
      } else {
        undistorter_.undistort(camera, rows.first, rows.count);
      }
      break;
    }
    case polygons:
      if (pass == 0) {
        const Run range = things(run, kPolygons, setup_.polygons());
        setup_.cull(range.first, range.count);
      } else {
        setup_.finish();
        compare_stamps();
      }
      break;
    case surfaces:
      if (pass == 0) {
        bounds_.clear_surfaces();
      } else {
        bounds_.draw_surfaces(setup_, camera, options_.near_plane, rows_of(things(run, kRows, height)));
      }
      break;
    case contours:
      issue_contours(pass, run);
      break;
    case copying:
      store_.catch_up(at_once_ ? store_.catch_up_left() : run.count * kCopyBytes);
      cursor_.set_units_left(pass, units_of(store_.catch_up_left(), kCopyBytes));
      break;
    case patches:
      issue_patches(pass, run);
      break;
    case gathering:
      issue_gathering(pass, run);
      break;
    case pulling:
      issue_pulling(pass, run);
      break;
    case pushing: {
      const int level = ChartPyramid::kPatchLevels - 1 - static_cast<int>(pass);
      pyramid_.push_level(level, listed(run, level > 0 ? PatchLists::renewed : PatchLists::holed));
      break;
    }
    case states:
      issue_states(pass, run);
      break;
  }
}

void PictureWork::compare_stamps() {
  const Timestamp stamp = frame_.state.stamp;
  is_late_for_all_ = newest_of_all_ && stamp < *newest_of_all_;
  if (!is_late_for_all_) newest_of_all_ = stamp;
  for (const std::uint32_t chart : setup_.charts()) {
    is_late_[chart] = newest_[chart] && stamp < *newest_[chart];
    if (!is_late_[chart]) newest_[chart] = stamp;
  }
}

void PictureWork::issue_contours(std::size_t pass, const Run& run) {
  const CameraModel& camera = frame_.camera;
  const int diamonds = diamond_passes();
  const std::size_t rims = diamonds > 0 ? static_cast<std::size_t>(PictureBounds::rim_passes(diamonds)) : 0;
  const auto rows = [&](std::size_t per_unit, std::size_t total) {
    const Run range = things(run, per_unit, total);
    return PictureBounds::Rows{static_cast<int>(range.first), static_cast<int>(range.count)};
  };
  const auto height = static_cast<std::size_t>(camera.height);
  if (pass < rims) {
    bounds_.draw_rims(camera, diamonds, static_cast<int>(pass), rows(kRows, height));
  } else if (pass == rims) {
    bounds_.bound_cells(camera, diamonds, camera.is_distorted() ? undistorter_.texture() : 0, rows(kRows, height - 1));
  } else {
    bounds_.coarsen(camera, rows(1, static_cast<std::size_t>(PictureBounds::coarse_rows(camera))));
  }
}

void PictureWork::issue_patches(std::size_t pass, const Run& run) {
  const CameraModel& camera = frame_.camera;
  const Run candidates = pass == 1 || pass == 2 ? things(run, kCandidates, patches_.candidate_count()) : Run{};
  switch (pass) {
    case 0:
      patches_.begin(setup_, charts(), camera);
      pyramid_.list(charts());
      break;
    case 1:
      patches_.touch(camera, options_.near_plane, bounds_, candidates);
      break;
    case 2:
      exposure_->count(camera, options_.near_plane, undistorter_.texture(), bounds_, patches_,
                       pyramid_.observed(ExposureEstimator::kLevel), store_.exposure(), candidates);
      break;
    case 3:
      exposure_->find_gain(store_.exposure(), is_late_for_all_);
      break;
    default:
      patches_.fetch();
  }
}

void PictureWork::issue_gathering(std::size_t pass, const Run& run) {
  const CameraModel& camera = frame_.camera;
  if (pass == 0) {
    std::optional<std::span<const std::uint32_t>> touched;
    if (!at_once_) touched = patches_.fetched_touched();
    gatherer_.list(setup_, is_late_, camera, touched);
    cursor_.set_units_left(1, gatherer_.units());
  } else if (pass == 1) {
    gatherer_.gather(camera, options_.near_plane, undistorter_.texture(), store_.exposure(), bounds_, patches_,
                     pages_.level(0).targets, run);
  } else {
    std::optional<Run> groups;
    if (!at_once_) {
      groups = things(run, kMarkGroups, units_of(lengths_[PatchLists::touched], PatchLists::kPatchesPerGroup));
    }
    marker_.mark(store_.capture_times(), store_.capture_time_of(frame_.state.stamp), setup_, is_late_, camera,
                 options_.near_plane, bounds_, patches_, groups);
  }
}

void PictureWork::issue_pulling(std::size_t pass, const Run& run) {
  const auto tip = pass - std::min<std::size_t>(pass, ChartPyramid::kPatchLevels);
  const auto tip_passes = static_cast<std::size_t>(pyramid_.tip_passes());
  if (pass < ChartPyramid::kPatchLevels) {
    pyramid_.pull_level(static_cast<int>(pass) + 1, ChartPyramid::Pull::show, listed(run, PatchLists::touched));
  } else if (tip < tip_passes) {
    pyramid_.draw_tip(static_cast<int>(tip), things(run, kCharts, pyramid_.charts()));
  } else if (tip == tip_passes) {
    pyramid_.renew(things(run, kCandidates, patches_.candidate_count()));
  } else {
    patches_.fetch();
  }
}

void PictureWork::issue_states(std::size_t pass, const Run& run) {
  if (pass == 0) {
    pyramid_.write_states(store_.polygon_states());
  } else {
    store_.spread_to_never_seen(TextureStore::kRimsPerPicture, static_cast<unsigned>(run.first),
                                static_cast<unsigned>(run.count));
  }
}

void PictureWork::end() {
  touched_polygons_.clear();
  for (const std::uint32_t chart : charts()) {
    const auto members = store_.layout().members_of(store_.layout().groups[chart]);
    touched_polygons_.insert(touched_polygons_.end(), members.begin(), members.end());
  }
  store_.end_picture(touched_polygons_, frame_.state.stamp);
  last_camera_ = frame_.camera;
  if (last_camera_.width > 1 && last_camera_.height > 1) adopted_ = false;
  frame_.picture.release();
}

void PictureWork::forget() {
  pyramid_.clear();
  patches_.clear();
  std::ranges::fill(newest_, std::nullopt);
  newest_of_all_.reset();
  if (exposure_) exposure_->clear();
  adopted_ = false;
  frame_.picture.release();
}

void PictureWork::adopt() {
  forget();
  set_up_passes();
  patches_.touch_all();
  pyramid_.pull(all_charts_, ChartPyramid::Pull::leave_pages);
  adopted_ = true;
}

void PictureWork::describe(ExtractionStatistics& statistics) const {
  statistics.polygons_visible = setup_.visible().size();
  statistics.polygons_skipped_back_face = setup_.back_faces();
  statistics.polygons_skipped_outside = setup_.outside();
  statistics.charts_touched = setup_.charts().size();
  statistics.texels_written = gatherer_.texels();
  if (!counting_) return;
  constexpr std::size_t kTexels = std::size_t{kPatchTexels} * kPatchTexels;
  const auto lengths = patches_.lengths();
  statistics.texels_filled = lengths[PatchLists::renewed] * kTexels;
  statistics.texels_written = std::min(statistics.texels_written, lengths[PatchLists::touched] * kTexels);
  statistics.texels_observed = gatherer_.observed();
}

void PictureWork::set_counting(bool on) {
  counting_ = on;
  gatherer_.set_counting(on);
}

}  // namespace foreview::batched
