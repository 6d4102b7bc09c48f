#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/server/frame_source.h"
#include "foreview/viewer/frame_schedule.h"
#include "foreview/viewer/loop_platform.h"

namespace foreview {

/// What became of one picture. Times are the platform's (steady clock) but for `captured` and `received`.
struct PictureRecord {
  std::size_t camera = 0, index = 0;
  Timestamp captured;                                 ///< in the source's time
  Timestamp received;                                 ///< in the source's time
  std::uint64_t picture = 0;                          ///< its number, as TextureStore::Shown::picture
  Timestamp begun, finished;                          ///< extraction took it up; the GPU had done all of it
  Timestamp displayed;                                ///< the first frame with its textures was complete
  Duration age_when_displayed;                        ///< since its capture, by the source's time
  std::array<double, kExtractionSteps> step_ms = {};  ///< wall clock of its slices, by ExtractionStep
  std::size_t slices = 0;
  std::uint64_t frames_meanwhile = 0;  ///< drawn between `begun` and `finished`
};

/// A picture whose textures are shown.
struct ShownPicture {
  PictureRecord record;
  CameraFrame frame;  ///< the picture itself; copying it copies no pixels
};

/// What a frame is to show.
struct FrameMoment {
  std::int64_t number = 0;    ///< of the frames drawn, from 0
  Timestamp now;              ///< drawing begins: newer input than this there is none
  Timestamp seen;             ///< when it will be seen: predict the state and the operator's own motion for then
  Duration period;            ///< between frames now
  std::uint64_t picture = 0;  ///< TextureStore::Shown::picture: the textures of this frame
  /// Of each camera that gave any, the picture captured last of those in these textures, since the last restart(), by
  /// camera. Valid until the callback returns.
  std::span<const ShownPicture> pictures;
  /// The one of them that was captured last; null where there is none.
  const ShownPicture* newest = nullptr;
};

/// What became of one frame.
struct FrameRecord {
  std::int64_t number = 0;
  Timestamp due, started, completed;  ///< completed: the GPU had drawn it, and present() had returned
  std::uint64_t picture = 0;
};

/// One slice.
struct SliceRecord {
  std::size_t kind = 0;  ///< of ExtractionPipeline::slice_kinds()
  double size = 0;
  Timestamp started, completed;
};

/// Shows frames at a steady rate while pictures are extracted beside them (design 6; spec 10): drives FrameSchedule
/// with a clock and two GL contexts, in one thread. The display's context is current whenever a member returns and in
/// callbacks that do not say otherwise; extraction's only while a slice runs.
///
/// @code
///   LiveScene scene(model, options, display.display(), display.context(), [&] { display.make_current(); });
///   PredictedView view(scene.store());
///   DisplayLoop loop(scene.platform(), {.period = {20'000'000}}, scene.store(), source,
///                    {.poll = ..., .draw = ..., .present = ..., .restart = [&] { scene.restart(); }});
///   loop.set_extraction(&scene.extraction());
///   while (loop.run_frame()) { loop.statistics() ... }
/// @endcode
///
/// Framebuffers and vertex arrays are not shared between contexts: what owns them belongs to one of the two.
class DisplayLoop {
 public:
  struct Options {
    Duration period{20'000'000};  ///< 1 / F_d
    Duration slice{2'500'000};    ///< slices are cut to what usually takes no longer than this
    Duration frame{5'000'000};    ///< first guess of what drawing a frame takes
    Duration margin{500'000};     ///< FrameSchedule::Options::margin
    /// present() may wait for the display's vertical blank; else what it takes is part of drawing the frame.
    bool present_waits = false;
  };
  struct Callbacks {
    /// When a frame is about to be drawn: take in the newest input. False: no frame, run_frame() returns false.
    std::function<bool()> poll;
    /// Draw the frame: all that can be done before present(), into the window's framebuffer, too. Called within
    /// acquire() and release() of the store.
    std::function<void(const FrameMoment&)> draw;
    /// Show what was drawn: swap. May be empty.
    std::function<void()> present;
    /// The source has a new generation (the replay began anew, or was moved in time): forget what earlier pictures left
    /// in the textures, and the one that is being extracted, as LiveScene::restart() does. In extraction's context.
    std::function<void()> restart;
    /// For records; may be empty. `displayed`: the picture's textures were first shown by a frame.
    std::function<void(const FrameRecord&)> frame_completed;
    std::function<void(const PictureRecord&)> displayed;
    std::function<void(const SliceRecord&)> slice_completed;  ///< in extraction's context
  };
  struct Statistics {
    Duration period;                     ///< between frames, wanted
    double frames_per_second = 0;        ///< reached, over the last second
    FrameSchedule::Statistics schedule;  ///< frames late, skipped, missed; slices
    Duration frame_cost;                 ///< reckoned for the next frame
    std::size_t pictures_begun = 0, pictures_finished = 0;
    std::size_t pictures_refused = 0;         ///< could not be extracted from; the first is logged with its reason
    std::size_t restarts = 0;                 ///< new generations of the source
    double pictures_per_second = 0;           ///< finished, over the last few
    std::deque<PictureRecord> last_pictures;  ///< finished, at most kKept, the newest last
  };
  static constexpr std::size_t kKept = 64;

  /// All must outlive the loop. Frames start at once, a period after this. The store must be `buffered`, and the
  /// display's context current.
  DisplayLoop(LoopPlatform& platform, const Options& options, TextureStore& store, FrameSource& source,
              Callbacks callbacks);
  ~DisplayLoop();
  DisplayLoop(const DisplayLoop&) = delete;
  DisplayLoop& operator=(const DisplayLoop&) = delete;

  /// Extracts with this from now on; null: not at all. It must not be busy, and live until it is replaced. To replace
  /// one that is busy, clear() it, or let it finish: is_extracting() says.
  void set_extraction(ExtractionPipeline* extraction);
  [[nodiscard]] bool is_extracting() const;
  /// Other pictures than those from `source` no longer are taken from now on. It must outlive the loop.
  void set_source(FrameSource& source);
  void set_period(Duration period);

  /// Extracts and waits until the next frame was drawn and presented. False if poll() asked for the end. What callbacks
  /// throw passes through, and so does ContextLost; after another exception than ContextLost the loop can go on.
  bool run_frame();
  /// run_frame() until the clock has passed `end`, or poll() asked for the end.
  void run_until(Timestamp end);

  [[nodiscard]] Statistics statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
