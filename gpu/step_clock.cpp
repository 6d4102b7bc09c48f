#include "foreview/gpu/step_clock.h"

#include <epoxy/gl.h>

namespace foreview {

StepClock::StepClock(ExtractionTiming timing) : timing_(timing) {
  if (timing_ == ExtractionTiming::off) return;
  // What was issued before is not this picture's.
  glFinish();
  start_ = std::chrono::steady_clock::now();
}

double StepClock::now() const {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
}

void StepClock::lap(ExtractionStep step) {
  if (timing_ == ExtractionTiming::off) return;
  StepSpan& span = spans_.emplace_back();
  span.step = step;
  span.cpu_begin = span.gpu_begin = last_;
  span.cpu_end = now();
  glFinish();
  span.gpu_end = last_ = now();
}

void StepClock::report(ExtractionStatistics& statistics) {
  if (timing_ == ExtractionTiming::off) return;
  for (const StepSpan& span : spans_) {
    statistics.step_ms[static_cast<std::size_t>(span.step)] += span.gpu_end - span.gpu_begin;
  }
  statistics.total_ms += last_;
  statistics.spans = std::move(spans_);
}

}  // namespace foreview
