#pragma once
#include <deque>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/scene/errors.h"
#include "foreview/server/frame_source.h"
#include "foreview/viewer/loop_platform.h"

namespace foreview::test {

inline constexpr Duration ms(double milliseconds) {
  return {static_cast<std::int64_t>(milliseconds * 1e6)};
}

/// Time passes only when someone says that it does; which context is current is kept; faults come as ordered. GL calls
/// go where they go: to the test's context.
class SimulatedPlatform final : public LoopPlatform {
 public:
  Timestamp time{1'000'000'000};
  bool extraction_is_current = false;
  std::size_t switches = 0;
  Duration each_switch, each_finish;
  std::function<void(const char*)> on_finish;  ///< may throw
  Duration oversleep;

  [[nodiscard]] Timestamp now() override { return time; }
  void sleep_until(Timestamp when) override {
    if (when > time) time = when + oversleep;
  }
  void use_display_context() override { change(false); }
  void in_extraction(const std::function<void()>& work) override {
    change(true);
    work();
  }
  void finish(const char* what) override {
    glFinish();
    time = time + each_finish;
    if (on_finish) on_finish(what);
  }

 private:
  void change(bool extraction) {
    if (std::exchange(extraction_is_current, extraction) == extraction) return;
    ++switches;
    time = time + each_switch;
  }
};

/// Pictures without pixels, that come at given times.
class SimulatedSource final : public FrameSource {
 public:
  explicit SimulatedSource(SimulatedPlatform& platform) : platform_(platform) {}
  struct Arrival {
    Timestamp when;
    IncomingFrame frame;
  };
  std::deque<Arrival> arrivals;
  std::uint64_t current_generation = 0;
  std::size_t taken = 0;

  void add(Timestamp when, std::size_t index) {
    IncomingFrame frame;
    frame.index = index;
    frame.frame.state.stamp = when - ms(40);
    frame.received = when;
    frame.generation = current_generation;
    arrivals.push_back({when, std::move(frame)});
  }
  [[nodiscard]] std::optional<IncomingFrame> take() override {
    std::optional<IncomingFrame> newest;
    while (!arrivals.empty() && arrivals.front().when <= platform_.time) {
      newest = std::move(arrivals.front().frame);
      arrivals.pop_front();
    }
    if (newest) ++taken;
    return newest;
  }
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp) const override { return std::nullopt; }
  [[nodiscard]] SourceStatus status() override { return {}; }
  [[nodiscard]] Timestamp time_at(Timestamp steady) const override { return steady; }
  [[nodiscard]] std::uint64_t generation() const override { return current_generation; }
  [[nodiscard]] std::size_t cameras() const override { return 1; }
  [[nodiscard]] std::optional<CameraModel> camera_model(std::size_t) const override { return std::nullopt; }

 private:
  SimulatedPlatform& platform_;
};

/// Pictures of `units` of work in one kind of slices, and then one that hands the picture over. Simulated time passes
/// by what they cost; nothing is drawn.
class SimulatedExtraction final : public ExtractionPipeline {
 public:
  SimulatedExtraction(SimulatedPlatform& platform, TextureStore& store) : platform_(platform), store_(store) {}
  double units = 20, least = 0.5;
  Duration constant = ms(0.2), per_unit = ms(1), handing_over = ms(0.5);
  std::function<void(const CameraFrame&)> on_begin;  ///< may throw
  std::function<void()> on_slice;                    ///< may throw
  struct Run {
    double size;
    Timestamp started;
    Duration took;
  };
  std::vector<Run> runs;
  std::size_t cleared = 0;

  ExtractionStatistics extract(const CameraFrame&) override { throw std::logic_error("not in slices"); }
  [[nodiscard]] std::span<const SliceKind> slice_kinds() const override {
    static constexpr std::array<SliceKind, 2> kKinds{{{"work", ExtractionStep::normalisation, 0.5, 2, "units"},
                                                      {"publish", ExtractionStep::publishing, 1, 0, "pictures"}}};
    return kKinds;
  }
  void begin(CameraFrame frame) override {
    expect_context("begin");
    if (on_begin) on_begin(frame);
    left_ = units;
    busy_ = true;
  }
  [[nodiscard]] bool is_busy() const override { return busy_; }
  [[nodiscard]] std::optional<ExtractionSlice> pending_slice() override {
    if (!busy_) return std::nullopt;
    if (!writing_ && !store_.has_free_set()) return std::nullopt;
    if (left_ > 0) return ExtractionSlice{0, left_, std::min(least, left_)};
    return ExtractionSlice{1, 1, 1};
  }
  double run_slice(double size) override {
    expect_context("run_slice");
    if (on_slice) on_slice();
    const Timestamp started = platform_.time;
    if (!writing_) {
      if (!store_.begin_picture()) throw std::logic_error("no free set");
      writing_ = true;
    }
    if (left_ > 0) {
      size = std::clamp(size, std::min(least, left_), left_);
      left_ -= size;
      platform_.time = platform_.time + constant +
                       Duration{static_cast<std::int64_t>(size * static_cast<double>(per_unit.nanoseconds))};
    } else {
      platform_.time = platform_.time + handing_over;
      store_.end_picture({});
      writing_ = busy_ = false;
    }
    runs.push_back({size, started, platform_.time - started});
    return size;
  }
  void clear() override {
    expect_context("clear");
    ++cleared;
    if (writing_) store_.end_picture({});
    busy_ = writing_ = false;
  }
  void adopt_store() override {}
  void set_timing(ExtractionTiming) override {}
  void set_counting(bool) override {}

 private:
  void expect_context(const char* what) const {
    if (!platform_.extraction_is_current) throw std::logic_error(std::string(what) + " in the display's context");
  }
  SimulatedPlatform& platform_;
  TextureStore& store_;
  double left_ = 0;
  bool busy_ = false, writing_ = false;
};

}  // namespace foreview::test
