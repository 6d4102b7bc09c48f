#include "foreview/gpu/batched/batched_extraction.h"

#include <cassert>
#include <limits>
#include <utility>

#include "foreview/gpu/batched/picture_work.h"
#include "foreview/gpu/draw_tally.h"
#include "foreview/gpu/step_clock.h"
#include "foreview/gpu/timer_queries.h"
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

}  // namespace

struct BatchedExtraction::State {
  State(TextureStore& store, const ExtractionOptions& options) : work(store, validated(options)) {}
  [[nodiscard]] PictureWork::Phase current() const { return static_cast<PictureWork::Phase>(phase); }

  PictureWork work;
  TimerQueries timer_queries;
  ExtractionTiming timing = ExtractionTiming::off;
  // Of the picture that was begun in slices.
  bool is_busy = false;
  std::size_t phase = 0;
  bool entered = false;
  DrawTally tally_before, tally;
  ExtractionStatistics statistics;
};

BatchedExtraction::BatchedExtraction(TextureStore& store, const ExtractionOptions& options)
    : state_(std::make_unique<State>(store, options)) {}
BatchedExtraction::~BatchedExtraction() = default;

ExtractionStatistics BatchedExtraction::extract(const CameraFrame& frame) {
  State& s = *state_;
  assert(!s.is_busy);
  check_frame(frame, s.work.store().model());
  Undistorter::check(frame.picture, frame.camera, name_of(frame));
  ExtractionStatistics statistics;
  StepClock clock(s.timing, &s.timer_queries);
  const DrawTally tally_before = draw_tally();
  s.work.begin(frame, true);
  for (std::size_t i = 0; i < PictureWork::kPhases; ++i) {
    const auto phase = static_cast<PictureWork::Phase>(i);
    if (phase == PictureWork::copying) s.work.store().wait_for_free_set();
    [[maybe_unused]] const bool entered = s.work.enter(phase);
    assert(entered);
    SliceCursor& cursor = s.work.cursor();
    while (!cursor.is_at_end()) {
      const auto piece = cursor.take(std::numeric_limits<double>::max(), true);
      const ExtractionStep step = cursor.pass(piece->pass).step;
      s.work.issue(phase, *piece);
      if (cursor.is_at_end() || cursor.present().step != step) clock.lap(step);
    }
  }
  s.work.end();
  clock.lap(ExtractionStep::publishing);
  statistics.draw_calls = draw_tally().draw_calls - tally_before.draw_calls;
  statistics.passes = draw_tally().passes - tally_before.passes;
  clock.report(statistics);
  s.work.describe(statistics);
  return statistics;
}

std::span<const SliceKind> BatchedExtraction::slice_kinds() const {
  return PictureWork::kinds();
}

void BatchedExtraction::begin(CameraFrame frame) {
  State& s = *state_;
  assert(!s.is_busy);
  check_frame(frame, s.work.store().model());
  Undistorter::check(frame.picture, frame.camera, name_of(frame));
  s.work.begin(std::move(frame), false);
  s.is_busy = true;
  s.phase = 0;
  s.entered = false;
  s.tally = {};
}

bool BatchedExtraction::is_busy() const {
  return state_->is_busy;
}

std::optional<ExtractionSlice> BatchedExtraction::pending_slice() {
  State& s = *state_;
  while (s.is_busy) {
    if (!s.entered) s.entered = s.work.enter(s.current());
    if (!s.entered) return std::nullopt;
    const SliceCursor& cursor = s.work.cursor();
    if (!cursor.is_at_end()) return ExtractionSlice{s.phase, cursor.left(), cursor.least()};
    end_phase();
  }
  return std::nullopt;
}

double BatchedExtraction::run_slice(double size) {
  State& s = *state_;
  assert(s.is_busy && s.entered && !s.work.cursor().is_at_end());
  const DrawTally before = draw_tally();
  SliceCursor& cursor = s.work.cursor();
  double done = 0;
  s.work.resume();
  while (!cursor.is_at_end()) {
    const auto piece = cursor.take(size - done, done == 0);
    if (!piece) break;
    s.work.issue(s.current(), *piece);
    done += piece->size;
  }
  s.tally.draw_calls += draw_tally().draw_calls - before.draw_calls;
  s.tally.passes += draw_tally().passes - before.passes;
  // What comes last need not wait to be asked for.
  if (s.phase == PictureWork::states && cursor.is_at_end()) end_phase();
  return done;
}

void BatchedExtraction::end_phase() {
  State& s = *state_;
  s.entered = false;
  if (++s.phase < PictureWork::kPhases) return;
  s.work.end();
  s.is_busy = false;
  s.statistics = {};
  s.statistics.draw_calls = s.tally.draw_calls;
  s.statistics.passes = s.tally.passes;
  s.work.describe(s.statistics);
}

const ExtractionStatistics& BatchedExtraction::statistics() const {
  return state_->statistics;
}

void BatchedExtraction::clear() {
  State& s = *state_;
  TextureStore& store = s.work.store();
  // Its set of textures is chosen before `patches`.
  if (s.is_busy && (s.phase > PictureWork::copying || (s.phase == PictureWork::copying && s.entered))) {
    store.abandon_picture();
  }
  s.is_busy = false;
  store.clear();
  s.work.forget();
}

void BatchedExtraction::adopt_store() {
  assert(!state_->is_busy);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  // Nothing of what was seen before may stay. The pages, which the display may be reading, stay as they are until the
  // next picture.
  state_->work.adopt();
}

void BatchedExtraction::set_timing(ExtractionTiming timing) {
  state_->timing = timing;
}

void BatchedExtraction::set_counting(bool on) {
  state_->work.set_counting(on);
}

BatchedExtraction::Intermediate BatchedExtraction::intermediate() const {
  const PictureWork& work = state_->work;
  const int width = work.last_camera().width, height = work.last_camera().height;
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
  return {work.bounds().read_surfaces(width, height), work.bounds().read_unsafe(width, height),
          work.bounds().read_cells(width, height), work.undistorter().read()};
}

std::vector<cv::Mat> BatchedExtraction::pulled(int level) const {
  return state_->work.pyramid().read_pulled(level);
}

}  // namespace foreview
