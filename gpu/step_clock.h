#pragma once
#include <chrono>
#include <cstdint>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/timer_queries.h"

namespace foreview {

/// Times the steps of one picture. Begins when made; lap() says that the step since the last lap ends here; report()
/// fills in the statistics. Does nothing, and waits for nothing, with ExtractionTiming::off. A step's time runs from
/// the end of the step before to its own end, so that step_ms add up to total_ms: with `finish` on the wall clock, with
/// `queries` on the GPU's, a GPU that waits for commands included.
class StepClock {
 public:
  /// `queries` is where `ExtractionTiming::queries` takes its query objects from, to be kept from picture to picture
  /// and outlive the clock; without, they are made anew for each picture.
  explicit StepClock(ExtractionTiming timing, TimerQueries* queries = nullptr);
  StepClock(const StepClock&) = delete;
  StepClock& operator=(const StepClock&) = delete;
  void lap(ExtractionStep step);
  /// Adds what was measured to `statistics`; with `queries` waits for the GPU. Once, at the end.
  void report(ExtractionStatistics& statistics);

 private:
  [[nodiscard]] double now() const;  ///< milliseconds since the clock was made
  void resolve_queries();

  ExtractionTiming timing_;
  TimerQueries own_queries_;
  TimerQueries* queries_;
  std::chrono::steady_clock::time_point start_;
  std::int64_t gl_start_ = 0;  ///< GL's clock at start_, nanoseconds
  double last_ = 0;
  std::vector<StepSpan> spans_;
};

}  // namespace foreview
