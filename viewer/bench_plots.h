#pragma once
#include <string>
#include <vector>

#include "foreview/viewer/bench_report.h"

namespace foreview {

/// Figures of an HTML report: a heading, the plot as inline SVG, its legend. Empty where there is nothing to plot.

/// Every picture's steps, stacked, in the order of the pictures; and what the pictures cost without per-step waits.
[[nodiscard]] std::string steps_plot(const BenchRun& run);
/// How the pictures' totals are distributed, one colour per run.
[[nodiscard]] std::string distribution_plot(const std::vector<const BenchRun*>& runs);
/// The steps' shares of the time, one bar per run, and 2005's above them where `with_2005`.
[[nodiscard]] std::string shares_plot(const std::vector<const BenchRun*>& runs, bool with_2005);
/// Curves of the same id, one colour per pipeline, on logarithmic axes; dashed what grows linearly from the last point.
[[nodiscard]] std::string scaling_plot(const std::vector<const ScalingCurve*>& curves);

}  // namespace foreview
