#pragma once
#include <chrono>

#include "foreview/gpu/extraction.h"

namespace foreview {

/// Times the steps of one picture. Begins when made; lap() says that the step since the last lap ends here; report()
/// fills in the statistics. Does nothing, and waits for nothing, with ExtractionTiming::off.
class StepClock {
 public:
  explicit StepClock(ExtractionTiming timing);
  void lap(ExtractionStep step);
  /// Adds what was measured to `statistics`; with `queries` waits for the GPU. Once, at the end.
  void report(ExtractionStatistics& statistics);

 private:
  [[nodiscard]] double now() const;  ///< milliseconds since the clock was made

  ExtractionTiming timing_;
  std::chrono::steady_clock::time_point start_;
  double last_ = 0;
  std::vector<StepSpan> spans_;
};

}  // namespace foreview
