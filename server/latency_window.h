#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <vector>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// The last so many durations, and their median and other quantiles.
class LatencyWindow {
 public:
  explicit LatencyWindow(std::size_t most = 2000) : most_(most) {}
  void add(Duration duration) {
    last_.push_back(duration);
    if (last_.size() > most_) last_.pop_front();
  }
  [[nodiscard]] std::size_t count() const { return last_.size(); }
  /// Nearest rank; nothing where nothing was added.
  [[nodiscard]] Duration quantile(double fraction) const {
    if (last_.empty()) return {};
    std::vector<Duration> sorted(last_.begin(), last_.end());
    const auto rank = static_cast<std::ptrdiff_t>(std::lround(fraction * static_cast<double>(sorted.size() - 1)));
    std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
    return sorted[static_cast<std::size_t>(rank)];
  }

 private:
  std::size_t most_;
  std::deque<Duration> last_;
};

}  // namespace foreview
