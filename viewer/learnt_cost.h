#pragma once
#include <cstddef>
#include <limits>
#include <vector>

namespace foreview {

/// What a kind of work costs, as a part of the bound that was declared for it: learnt from the last few times.
///
/// The ratios observed / declared of the last `window` times are kept; at first all of them are 1, the declared bound.
/// The cost to reckon with is the greatest of them after the `ignored` greatest: with 32 and 1, a cost that was seen
/// twice among the last 32 times counts, and a single outlier does not, however large. So the cost rises at the second
/// larger observation, and falls once the window has passed over all but one of the larger ones: quick to rise, slow to
/// fall, about the 95 % quantile, and forgets everything after `window` observations.
class LearntCost {
 public:
  struct Options {
    std::size_t window = 32;  ///< at least 2 (ignored + 1)
    std::size_t ignored = 1;
    double floor = 0;  ///< no ratio below this is believed; 1: the declared bound is never undercut
  };
  explicit LearntCost(Options options);

  /// `ratio`: observed / declared, not negative.
  void observe(double ratio);

  /// The ratio to reckon with; of the observations up to `limit` only, where those above it could not be afforded in
  /// any case. `limit` must be at least median().
  [[nodiscard]] double high(double limit = std::numeric_limits<double>::infinity()) const;
  /// The upper median of the window.
  [[nodiscard]] double median() const;

 private:
  Options options_;
  std::vector<double> ratios_;  ///< a ring
  std::size_t oldest_ = 0;
};

}  // namespace foreview
