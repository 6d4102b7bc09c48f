#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace foreview {

/// How figures are spread. Between two neighbouring figures a quantile is interpolated linearly.
struct Quantiles {
  std::size_t count = 0;                                             ///< 0: nothing below holds
  double least = 0, lower = 0, median = 0, upper = 0, greatest = 0;  ///< lower, upper: the quartiles
};
[[nodiscard]] Quantiles quantiles_of(std::vector<double> figures);
/// The figure below which a part `p` (0..1) of them lie; of ascending figures, at least one.
[[nodiscard]] double quantile(std::span<const double> ascending, double p);

/// How a cost t grows with a size x.
struct GrowthFit {
  double constant = 0,
         slope = 0;             ///< t = constant + slope x, by Theil and Sen: the median slope of all pairs of points
  double exponent = 0;          ///< k of t ~ x^k, the same way on logarithms: below 1 where a constant part dominates
  double exponent_at_end = 0;   ///< k over the larger half of the sizes (at least three), where a constant hides least
  bool at_most_linear = false;  ///< exponent_at_end <= kLinearExponent
};
inline constexpr double kLinearExponent = 1.1;  ///< what a tenth of noise between the ends of a decade makes of 1

/// `sizes` ascending and positive, at least two of them different; `costs` positive, as many.
[[nodiscard]] GrowthFit fit_growth(std::span<const double> sizes, std::span<const double> costs);

}  // namespace foreview
