#include "foreview/viewer/learnt_cost.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <iterator>

namespace foreview {

LearntCost::LearntCost(Options options) : options_(options), ratios_(options.window, 1.0) {
  assert(options.window >= 2 * (options.ignored + 1) && options.floor >= 0);
}

void LearntCost::observe(double ratio) {
  assert(ratio >= 0);
  ratios_[oldest_] = ratio;
  oldest_ = (oldest_ + 1) % ratios_.size();
}

double LearntCost::high(double limit) const {
  std::vector<double> affordable;
  affordable.reserve(ratios_.size());
  std::copy_if(ratios_.begin(), ratios_.end(), std::back_inserter(affordable), [&](double r) { return r <= limit; });
  // No fewer than the median leaves; but a limit that was rounded below the median must not lead astray.
  if (affordable.size() <= options_.ignored) {
    return std::max(limit, options_.floor);
  }
  const auto greatest = affordable.begin() + static_cast<std::ptrdiff_t>(options_.ignored);
  std::nth_element(affordable.begin(), greatest, affordable.end(), std::greater<>());
  return std::max(*greatest, options_.floor);
}

double LearntCost::median() const {
  std::vector<double> ratios = ratios_;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return std::max(*middle, options_.floor);
}

}  // namespace foreview
