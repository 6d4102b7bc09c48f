#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "foreview/viewer/display_loop.h"

namespace foreview {

/// How much of the system the process holds.
struct ResourceCounts {
  std::size_t resident_bytes = 0, open_files = 0, threads = 0;  ///< 0 where /proc does not tell
  long gl_objects = 0;                                          ///< live_gl_objects()
};
/// Of this process now.
[[nodiscard]] ResourceCounts count_resources();

/// What was measured while frames were shown, or pictures extracted, for a while.
struct PacingRun {
  /// Frames and pictures kept, the last ones: a run may take hours, and must not grow.
  static constexpr std::size_t kKept = 20'000;

  std::string name;          ///< "display alone", "extraction alone", "both"
  Duration period;           ///< between frames; 0: none were shown
  Timestamp started, ended;  ///< what came before (warming up) is not counted
  std::vector<FrameRecord> frames;
  std::vector<PictureRecord> pictures;                   ///< finished and, where there are frames, displayed
  std::size_t frames_dropped = 0, pictures_dropped = 0;  ///< beyond kKept
  std::size_t frames_late = 0;                           ///< complete after they were due, of all
  FrameSchedule::Statistics schedule;                    ///< since `started`
  std::size_t restarts = 0;                              ///< leaps from the recording's end to its start
  struct Kind {
    std::string name;
    std::size_t slices = 0, over_bound = 0;  ///< that took longer than slices are cut to
    double total_ms = 0, worst_ms = 0;
  };
  std::vector<Kind> slices;
  double slice_bound_ms = 0;
  /// Every kInterval since `started`, and at the end: what has become of the run's steadiness, and what it holds.
  static constexpr Duration kInterval{60'000'000'000};
  struct Interval {
    double seconds = 0;  ///< its end, since `started`
    std::size_t frames = 0, pictures = 0;
    std::int64_t late = 0, skipped = 0, missed = 0;
    double median_ms = 0, p99_ms = 0, worst_ms = 0;  ///< completion after the due time
    ResourceCounts resources;
  };
  std::vector<Interval> intervals;

  /// Adds to frames or pictures, dropping what is too old.
  void add(const FrameRecord& frame);
  void add(const PictureRecord& picture);
};

/// What became of a run's frames, all of them, and how those that were kept were spread in time, milliseconds.
struct PacingSummary {
  std::size_t frames = 0, late = 0;
  std::int64_t skipped = 0, missed = 0, slices = 0;
  double frames_per_second = 0;
  double worst_frames_per_second = 0;  ///< of any second
  struct Spread {
    double mean = 0, least = 0, median = 0, p95 = 0, p99 = 0, worst = 0;
  };
  Spread completion;  ///< after the due time: negative is early
  Spread interval;    ///< between completions
  Spread drawing;     ///< from start to completion
  std::size_t pictures = 0;
  double pictures_per_second = 0;
  Spread picture;    ///< from being taken up to being finished
  Spread displayed;  ///< from capture to the first frame with the picture's textures
};
[[nodiscard]] PacingSummary summary_of(const PacingRun& run);
[[nodiscard]] PacingSummary::Spread spread_of(std::vector<double> figures);

/// The part (0..1) of the frames that were complete no later after they were due than the reference's on average and a
/// quarter of a period; 1 where there are none. Frames skipped and missed count as not.
[[nodiscard]] double part_as_punctual(const PacingRun& run, const PacingRun& reference);

}  // namespace foreview
