#include "foreview/gpu/step_clock.h"

#include <epoxy/gl.h>

namespace foreview {

StepClock::StepClock(ExtractionTiming timing, TimerQueries* queries)
    : timing_(timing), queries_(queries != nullptr ? queries : &own_queries_) {
  if (timing_ == ExtractionTiming::off) return;
  // What was issued before is not this picture's.
  if (timing_ == ExtractionTiming::finish) glFinish();
  start_ = std::chrono::steady_clock::now();
  if (timing_ == ExtractionTiming::queries) {
    glGetInteger64v(GL_TIMESTAMP, &gl_start_);
    queries_->restart();
    queries_->mark();
  }
}

double StepClock::now() const {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
}

void StepClock::lap(ExtractionStep step) {
  if (timing_ == ExtractionTiming::off) return;
  StepSpan& span = spans_.emplace_back();
  span.step = step;
  span.cpu_begin = span.gpu_begin = last_;
  span.cpu_end = last_ = now();
  if (timing_ == ExtractionTiming::queries) {
    queries_->mark();
  } else {
    glFinish();
    span.gpu_end = last_ = now();
  }
}

void StepClock::resolve_queries() {
  const std::vector<std::int64_t> times = queries_->resolve();
  const auto milliseconds = [&](std::size_t mark) { return static_cast<double>(times[mark] - gl_start_) * 1e-6; };
  for (std::size_t i = 0; i < spans_.size(); ++i) {
    spans_[i].gpu_begin = milliseconds(i);
    spans_[i].gpu_end = milliseconds(i + 1);
  }
}

void StepClock::report(ExtractionStatistics& statistics) {
  if (timing_ == ExtractionTiming::off) return;
  if (timing_ == ExtractionTiming::queries) resolve_queries();
  for (const StepSpan& span : spans_) {
    statistics.step_ms[static_cast<std::size_t>(span.step)] += span.gpu_end - span.gpu_begin;
  }
  if (!spans_.empty()) statistics.total_ms += spans_.back().gpu_end - spans_.front().gpu_begin;
  statistics.spans = std::move(spans_);
}

}  // namespace foreview
