// One thread that alternates between two contexts, or two threads? Waiting for fences, or asking again and again? Runs
// DisplayLoop on a built-in recording each way. Not a test; run it on a quiet machine:
//   build/tests/viewer/display_loop_bench [RATE [SECONDS [WIDTHxHEIGHT [SLICE_MS]]]]
#include <epoxy/gl.h>

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/pacing_measurement.h"
#include "foreview/viewer/pacing_report.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/preloaded_source.h"
#include "foreview/viewer/render_target.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {
namespace {

class PollingPlatform : public LoopPlatform {
 public:
  explicit PollingPlatform(LoopPlatform& platform) : platform_(platform) {}
  [[nodiscard]] Timestamp now() override { return steady_now(); }
  void sleep_until(Timestamp when) override { platform_.sleep_until(when); }
  void use_display_context() override { platform_.use_display_context(); }
  void in_extraction(const std::function<void()>& work) override { platform_.in_extraction(work); }
  void finish(const char*) override {
    const GlFence fence = GlFence::insert();
    while (!fence.has_passed()) {
    }
  }

 private:
  LoopPlatform& platform_;
};

/// Extraction's context belongs to a thread of its own, which runs what it is given; the display's thread waits for it.
class TwoThreads : public LoopPlatform {
 public:
  TwoThreads(LoopPlatform& platform, OffscreenContext& extraction) : platform_(platform), extraction_(extraction) {
    thread_ = std::thread([this] { run(); });
  }
  ~TwoThreads() override {
    give([] {});
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  [[nodiscard]] Timestamp now() override { return steady_now(); }
  void sleep_until(Timestamp when) override { platform_.sleep_until(when); }
  void use_display_context() override {}
  void in_extraction(const std::function<void()>& work) override { give(work); }
  void finish(const char* what) override { platform_.finish(what); }

 private:
  void give(const std::function<void()>& work) {
    std::unique_lock lock(mutex_);
    work_ = &work;
    changed_.notify_all();
    changed_.wait(lock, [this] { return work_ == nullptr; });
    if (auto error = std::exchange(error_, nullptr)) std::rethrow_exception(error);
  }
  void run() {
    extraction_.make_current();
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return work_ != nullptr || stop_; });
      if (stop_) break;
      try {
        (*work_)();
      } catch (...) {
        error_ = std::current_exception();
      }
      work_ = nullptr;
      changed_.notify_all();
    }
    extraction_.release_current();
  }

  LoopPlatform& platform_;
  OffscreenContext& extraction_;
  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* work_ = nullptr;
  std::exception_ptr error_;
  bool stop_ = false;
  std::thread thread_;
};

void print(const char* name, const PacingRun& run, const PacingRun& reference) {
  const PacingSummary s = summary_of(run);
  std::printf(
      "%-34s %6.2f Hz  complete %6.2f  p99 %6.2f  worst %6.2f ms  %6.2f %% punctual  %5.2f pictures/s  "
      "%6.1f slices/s  slice %.2f ms\n",
      name, s.frames_per_second, s.completion.mean, s.completion.p99, s.completion.worst,
      100 * part_as_punctual(run, reference), s.pictures_per_second,
      static_cast<double>(s.slices) / (run.ended - run.started).seconds(),
      s.slices > 0 ? 1e3 * run.schedule.extraction.seconds() / static_cast<double>(s.slices) : 0);
  std::fflush(stdout);
}

void measure(double rate, double seconds, int width, int height, double slice_ms) {
  OffscreenContext display;
  ReplayOptions replay;
  replay.recording = "workcell";
  ReplayInput input(replay);
  LiveScene::Options options;
  options.extraction = replay.extraction;
  options.charts = input.charts;
  LiveScene scene(input.model, options, display.display(), display.context(), [&] { display.make_current(); });
  PreloadedSource source(input.recording, input.model, input.camera, input.recording.first_stamp(input.camera),
                         input.recording.last_stamp(input.camera), 40);
  PredictedView view(scene.store());
  AntialiasedTarget target;
  target.resize(width, height, "size", 1);
  const CameraModel camera = input.recording.cameras()[input.camera].model.undistorted();

  PacingRequest request;
  request.period = Duration::from_seconds(1 / rate);
  request.duration = Duration::from_seconds(seconds);
  request.loop.slice = Duration::from_seconds(slice_ms / 1e3);
  request.draw = [&](const FrameMoment& moment) {
    if (const auto state = source.predicted_state(source.time_at(moment.seen))) {
      ViewStyle style;
      style.quality = ViewQuality::fast;
      view.draw(camera, *state, style, target.framebuffer(), {0, 0, width, height}, false);
    }
    static_cast<void>(target.resolve());
  };
  const PacingRun alone = measure_extraction_alone(scene, source, request);
  std::printf("extraction alone: %.2f pictures/s\n", summary_of(alone).pictures_per_second);
  request.extraction = false;
  const PacingRun reference = measure_pacing(scene, source, request);
  print("display alone", reference, reference);
  request.extraction = true;
  for (int round = 0; round < 2; ++round) {
    print("one thread, waiting", measure_pacing(scene, source, request), reference);
    PollingPlatform polling(scene.platform());
    request.platform = &polling;
    print("one thread, asking again and again", measure_pacing(scene, source, request), reference);
    {
      TwoThreads two(scene.platform(), scene.extraction_context());
      request.platform = &two;
      print("two threads, waiting", measure_pacing(scene, source, request), reference);
    }
    request.platform = nullptr;
  }
}

}  // namespace
}  // namespace foreview

int main(int count, char** arguments) {
  int width = 800, height = 600;
  if (count > 3) std::sscanf(arguments[3], "%dx%d", &width, &height);
  foreview::measure(count > 1 ? std::atof(arguments[1]) : 33, count > 2 ? std::atof(arguments[2]) : 5, width, height,
                    count > 4 ? std::atof(arguments[4]) : 2.5);
}
