#pragma once
#include <epoxy/gl.h>

#include <chrono>

namespace foreview::per_polygon {

/// Wall clock between finished steps; GL's own timer queries cannot be trusted everywhere (design 5). Does nothing,
/// and waits for nothing, while switched off.
class StepTimer {
 public:
  explicit StepTimer(bool on) : on_(on) { lap(unused_); }
  /// Adds the time since the last lap, in milliseconds, to `step`.
  void lap(double& step) {
    if (!on_) return;
    glFinish();
    const auto now = std::chrono::steady_clock::now();
    step += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  bool on_;
  double unused_ = 0;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace foreview::per_polygon
