#include "foreview/viewer/bench_statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace foreview {
namespace {

double median_of(std::vector<double> figures) {
  return quantiles_of(std::move(figures)).median;
}

/// The median of the slopes between all pairs of points: a third of the points may be wild without harm.
double theil_sen_slope(std::span<const double> x, std::span<const double> y) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = i + 1; j < x.size(); ++j) {
      if (x[i] != x[j]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
    }
  }
  return median_of(std::move(slopes));
}

std::vector<double> logarithms(std::span<const double> values) {
  std::vector<double> result;
  for (const double value : values) result.push_back(std::log(value));
  return result;
}

}  // namespace

double quantile(std::span<const double> ascending, double p) {
  assert(!ascending.empty());
  const double place = p * static_cast<double>(ascending.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 >= ascending.size()) return ascending.back();
  return std::lerp(ascending[below], ascending[below + 1], place - static_cast<double>(below));
}

Quantiles quantiles_of(std::vector<double> figures) {
  Quantiles result;
  result.count = figures.size();
  if (figures.empty()) return result;
  std::ranges::sort(figures);
  result.least = figures.front();
  result.lower = quantile(figures, 0.25);
  result.median = quantile(figures, 0.5);
  result.upper = quantile(figures, 0.75);
  result.greatest = figures.back();
  return result;
}

GrowthFit fit_growth(std::span<const double> sizes, std::span<const double> costs) {
  assert(sizes.size() == costs.size() && sizes.size() >= 2 && std::ranges::is_sorted(sizes));
  GrowthFit fit;
  fit.slope = theil_sen_slope(sizes, costs);
  std::vector<double> rests;
  for (std::size_t i = 0; i < sizes.size(); ++i) rests.push_back(costs[i] - fit.slope * sizes[i]);
  fit.constant = median_of(std::move(rests));
  const std::vector<double> log_sizes = logarithms(sizes), log_costs = logarithms(costs);
  fit.exponent = theil_sen_slope(log_sizes, log_costs);
  const std::size_t end = std::max<std::size_t>(std::min<std::size_t>(3, sizes.size()), (sizes.size() + 1) / 2);
  const std::span<const double> all_sizes(log_sizes), all_costs(log_costs);
  fit.exponent_at_end = theil_sen_slope(all_sizes.last(end), all_costs.last(end));
  fit.at_most_linear = fit.exponent_at_end <= kLinearExponent;
  return fit;
}

}  // namespace foreview
