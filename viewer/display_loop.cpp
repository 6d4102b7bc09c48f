#include "foreview/viewer/display_loop.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

/// While there is nothing to extract, how often the source is asked for a picture.
constexpr Duration kAskAgain{1'000'000};
constexpr Duration kSecond{1'000'000'000};

Duration milliseconds(double ms) {
  return {static_cast<std::int64_t>(std::ceil(ms * 1e6))};
}

std::vector<FrameSchedule::Bound> bounds_of(const ExtractionPipeline* extraction) {
  std::vector<FrameSchedule::Bound> bounds;
  if (extraction == nullptr) return bounds;
  for (const SliceKind& kind : extraction->slice_kinds()) {
    bounds.push_back({milliseconds(kind.constant_ms), milliseconds(kind.per_unit_ms)});
  }
  return bounds;
}

}  // namespace

struct DisplayLoop::State {
  State(LoopPlatform& of_platform, const Options& of_options, TextureStore& of_store, FrameSource& of_source,
        Callbacks of_callbacks)
      : platform(of_platform),
        options(of_options),
        store(of_store),
        source(&of_source),
        callbacks(std::move(of_callbacks)),
        schedule(schedule_options(), platform.now()),
        generation(source->generation()) {
    assert(callbacks.draw);
  }

  [[nodiscard]] FrameSchedule::Options schedule_options() const {
    FrameSchedule::Options result;
    result.period = options.period;
    result.frame = options.frame;
    result.margin = options.margin;
    // A frame disturbed by something else on the machine leaves no room for a slice; that is not overload yet.
    result.patience = 2;
    // A slice that takes longer than reckoned delays a frame by its excess; one that is reckoned too long costs a whole
    // frame where it does not fit in any more. So more outliers are ignored than of frames.
    result.slice_cost = LearntCost::Options{.ignored = 3};
    result.slices = bounds_of(extraction);
    return result;
  }

  // Extraction.

  /// What the textures hold belongs to another generation than what is coming.
  void restart() {
    due.reset();
    platform.in_extraction([this] {
      if (callbacks.restart) {
        callbacks.restart();
      } else if (extraction != nullptr) {
        extraction->clear();
      }
      platform.finish("clearing textures");
    });
    newest_by_camera.clear();
    displayable.clear();
    ++restarts;
  }

  void take_picture() {
    std::optional<IncomingFrame> incoming = source->take();
    if (!incoming) return;
    if (incoming->generation != generation) {
      if (incoming->generation != source->generation()) return;  // void since it was taken
      generation = incoming->generation;
      restart();
    }
    begun = PictureRecord();
    begun.camera = incoming->camera;
    begun.index = incoming->index;
    begun.captured = incoming->frame.state.stamp;
    begun.received = incoming->received;
    begun.begun = platform.now();
    begun.frames_meanwhile = frames;
    begun_frame = incoming->frame;
    try {
      platform.in_extraction([&] {
        extraction->begin(std::move(incoming->frame));
        due = extraction->pending_slice();
      });
      ++pictures_begun;
    } catch (const InputError& error) {
      if (pictures_refused++ == 0) spdlog::warn("a picture was left out: {}", error.what());
    }
  }

  /// What extraction would do next, all of it.
  const std::optional<ExtractionSlice>& due_slice() {
    if (const std::uint64_t current = source->generation(); current != std::exchange(generation, current)) restart();
    if (extraction == nullptr) return due;
    if (due && !extraction->is_busy()) due.reset();  // its owner abandoned the picture
    if (due) return due;
    const Timestamp now = platform.now();
    if (now < ask_again) return due;
    if (extraction->is_busy()) {
      platform.in_extraction([this] { due = extraction->pending_slice(); });
    } else {
      take_picture();
    }
    if (!due) ask_again = now + kAskAgain;
    return due;
  }

  /// As much of it as there is room for before the next frame.
  [[nodiscard]] FrameSchedule::Slice cut(const ExtractionSlice& slice) const {
    // Whatever happens now and then, it fits in before the frame; if there is room enough, it is usually this long.
    const Duration room = std::max(schedule.frame_start() - platform.now(), Duration{});
    const double fits =
        std::min(schedule.size_within(slice.kind, room), schedule.typical_size_within(slice.kind, options.slice));
    return {slice.kind, std::clamp(fits, slice.least, slice.size)};
  }

  void run_slice(const FrameSchedule::Slice& slice) {
    platform.in_extraction([&] {
      const Timestamp started = platform.now();
      due.reset();
      const double size = extraction->run_slice(slice.size);
      platform.finish("extracting textures");
      slice_completed({slice.kind, size, started, platform.now()});
      if (extraction->is_busy()) due = extraction->pending_slice();
    });
  }

  void slice_completed(const SliceRecord& slice) {
    schedule.slice_started({slice.kind, slice.size}, slice.started);
    schedule.slice_completed(slice.completed);
    const auto step = static_cast<std::size_t>(extraction->slice_kinds()[slice.kind].step);
    begun.step_ms[step] += 1e3 * (slice.completed - slice.started).seconds();
    ++begun.slices;
    if (callbacks.slice_completed) callbacks.slice_completed(slice);
    if (!extraction->is_busy()) finish_picture(slice.completed);
  }

  void finish_picture(Timestamp when) {
    begun.finished = when;
    begun.picture = store.pictures_ended();
    begun.frames_meanwhile = frames - begun.frames_meanwhile;
    ++pictures_finished;
    displayable.push_back({begun, std::move(begun_frame)});
    begun_frame = {};
    if (displayable.size() > kKept) displayable.pop_front();
    last_pictures.push_back(begun);
    if (last_pictures.size() > kKept) last_pictures.pop_front();
  }

  // Display.

  bool draw_frame(Timestamp deadline) {
    platform.use_display_context();
    const Timestamp started = platform.now();
    const std::int64_t number = schedule.frame_started(started);
    bool handed_over = false;
    const auto hand_over = [&] {
      if (!std::exchange(handed_over, true)) schedule.frame_handed_over(platform.now());
    };
    try {
      const bool goes_on = !callbacks.poll || callbacks.poll();
      if (!goes_on) {
        hand_over();
        return false;
      }
      FrameMoment moment;
      moment.number = number;
      moment.now = platform.now();
      moment.seen = std::max(deadline, started + schedule.frame_cost());
      moment.period = options.period;
      draw(moment);
      if (options.present_waits) hand_over();
      if (callbacks.present) callbacks.present();
      const Timestamp completed = platform.now();
      hand_over();
      schedule.frame_completed(number, completed);
      report({number, deadline, started, completed, moment.picture});
    } catch (...) {
      hand_over();
      throw;
    }
    return true;
  }

  /// Brings newest_by_camera up to the textures with this number.
  std::span<const ShownPicture> newest_in(std::uint64_t textures) {
    for (const ShownPicture& finished : displayable) {
      if (finished.record.picture > textures) break;
      const auto same_camera = [&](const ShownPicture& known) { return known.record.camera >= finished.record.camera; };
      const auto known = std::find_if(newest_by_camera.begin(), newest_by_camera.end(), same_camera);
      if (known == newest_by_camera.end() || known->record.camera != finished.record.camera) {
        newest_by_camera.insert(known, finished);
      } else if (known->record.captured <= finished.record.captured) {
        *known = finished;
      }
    }
    return newest_by_camera;
  }

  void draw(FrameMoment& moment) {
    moment.picture = store.acquire().picture;
    try {
      moment.pictures = newest_in(moment.picture);
      const auto by_capture = [](const ShownPicture& a, const ShownPicture& b) {
        return a.record.captured < b.record.captured;
      };
      const auto newest = std::max_element(moment.pictures.begin(), moment.pictures.end(), by_capture);
      if (newest != moment.pictures.end()) moment.newest = &*newest;
      callbacks.draw(moment);
    } catch (...) {
      store.release();
      throw;
    }
    store.release();
    platform.finish("a frame");
  }

  void report(const FrameRecord& frame) {
    ++frames;
    completions.push_back(frame.completed);
    while (completions.front() < frame.completed - kSecond) completions.pop_front();
    if (callbacks.frame_completed) callbacks.frame_completed(frame);
    const Timestamp shown_at = source->time_at(frame.completed);
    // The source's time may have leapt since the frame was begun: the picture is void then, and ages mean nothing.
    if (source->generation() != generation) return;
    while (!displayable.empty() && displayable.front().record.picture <= frame.picture) {
      PictureRecord& picture = displayable.front().record;
      picture.displayed = frame.completed;
      picture.age_when_displayed = shown_at - picture.captured;
      for (PictureRecord& kept : last_pictures) {
        if (kept.picture == picture.picture) kept = picture;
      }
      for (ShownPicture& kept : newest_by_camera) {
        if (kept.record.picture == picture.picture) kept.record = picture;
      }
      if (callbacks.displayed) callbacks.displayed(picture);
      displayable.pop_front();
    }
  }

  bool run_frame() {
    for (;;) {
      const std::optional<ExtractionSlice>& slice = due_slice();
      std::optional<FrameSchedule::Slice> offered;
      if (slice) offered = cut(*slice);
      const FrameSchedule::Decision decision = schedule.next(platform.now(), offered);
      switch (decision.action) {
        case FrameSchedule::Action::draw_frame:
          return draw_frame(decision.until);
        case FrameSchedule::Action::run_slice:
          run_slice(*offered);
          break;
        case FrameSchedule::Action::wait_until:
          platform.sleep_until(slice || extraction == nullptr
                                   ? decision.until
                                   : std::min(decision.until, std::max(ask_again, platform.now())));
          break;
      }
    }
  }

  LoopPlatform& platform;
  Options options;
  TextureStore& store;
  FrameSource* source;
  Callbacks callbacks;
  ExtractionPipeline* extraction = nullptr;
  FrameSchedule schedule;

  std::optional<ExtractionSlice> due;  ///< as pending_slice() said, until it is run
  Timestamp ask_again;                 ///< for a picture or a slice, not before
  std::uint64_t generation = 0;        ///< of the source, that the textures belong to
  PictureRecord begun;                 ///< the picture being extracted
  CameraFrame begun_frame;
  std::deque<ShownPicture> displayable;  ///< finished, not displayed yet
  std::vector<ShownPicture> newest_by_camera;
  std::deque<PictureRecord> last_pictures;
  std::deque<Timestamp> completions;  ///< of frames, of the last second
  std::uint64_t frames = 0;
  std::size_t pictures_begun = 0, pictures_finished = 0, pictures_refused = 0, restarts = 0;
};

DisplayLoop::DisplayLoop(LoopPlatform& platform, const Options& options, TextureStore& store, FrameSource& source,
                         Callbacks callbacks)
    : state_(std::make_unique<State>(platform, options, store, source, std::move(callbacks))) {}
DisplayLoop::~DisplayLoop() = default;

void DisplayLoop::set_extraction(ExtractionPipeline* extraction) {
  State& state = *state_;
  assert(extraction == nullptr || !extraction->is_busy());
  state.extraction = extraction;
  state.due.reset();
  state.schedule.set_slices(bounds_of(extraction));
}

bool DisplayLoop::is_extracting() const {
  return state_->extraction != nullptr && state_->extraction->is_busy();
}

void DisplayLoop::set_source(FrameSource& source) {
  state_->source = &source;
  state_->generation = ~source.generation();
}

void DisplayLoop::set_period(Duration period) {
  if (period == state_->options.period) return;
  state_->options.period = period;
  state_->schedule.set_period(period, state_->platform.now());
}

bool DisplayLoop::run_frame() {
  bool goes_on = true;
  try {
    goes_on = state_->run_frame();
  } catch (...) {
    try {
      state_->platform.use_display_context();
    } catch (const std::exception& error) {
      spdlog::debug("{}", error.what());  // the first error is the one to tell
    }
    throw;
  }
  return goes_on;
}

void DisplayLoop::run_until(Timestamp end) {
  while (state_->platform.now() < end && run_frame()) {
  }
}

DisplayLoop::Statistics DisplayLoop::statistics() const {
  const State& state = *state_;
  Statistics result;
  result.period = state.options.period;
  result.schedule = state.schedule.statistics();
  result.frame_cost = state.schedule.frame_cost();
  result.pictures_begun = state.pictures_begun;
  result.pictures_finished = state.pictures_finished;
  result.pictures_refused = state.pictures_refused;
  result.restarts = state.restarts;
  result.last_pictures = state.last_pictures;
  const auto rate = [](std::size_t count, Timestamp first, Timestamp last) {
    return count > 1 && last > first ? static_cast<double>(count - 1) / (last - first).seconds() : 0.0;
  };
  if (!state.completions.empty()) {
    result.frames_per_second = rate(state.completions.size(), state.completions.front(), state.completions.back());
  }
  if (!state.last_pictures.empty()) {
    const std::size_t recent = std::min<std::size_t>(state.last_pictures.size(), 10);
    result.pictures_per_second = rate(recent, state.last_pictures[state.last_pictures.size() - recent].finished,
                                      state.last_pictures.back().finished);
  }
  return result;
}

}  // namespace foreview
