#include "foreview/viewer/bench_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "foreview/viewer/bench_svg.h"
#include "foreview/viewer/extraction_names.h"

namespace foreview {
namespace {

constexpr std::size_t kMostBars = 400;  // more pictures than this share bars, as means
constexpr int kMostBins = 40;

template <typename... Values>
std::string text_of(const char* format, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string step_class(std::size_t step) {
  return "s" + std::to_string(step);
}

std::string run_class(std::size_t run) {
  return "r" + std::to_string(run % 4);
}

std::string figure(const std::string& heading, const std::string& plot, const std::vector<LegendEntry>& legend,
                   const std::string& note = "") {
  return "<figure><figcaption>" + html_escaped(heading) + "</figcaption>\n" + plot + legend_html(legend) +
         (note.empty() ? "" : "<p class=\"note\">" + html_escaped(note) + "</p>\n") + "</figure>\n";
}

using StepTimes = std::array<double, kExtractionSteps>;

/// Sums over all pictures.
StepTimes summed_steps(const BenchRun& run) {
  StepTimes sum{};
  for (const SteppedCost& cost : run.stepped) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += cost.statistics.step_ms[i];
  }
  return sum;
}

std::vector<LegendEntry> legend_of(const StepTimes& used) {
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i] > 0) legend.push_back({step_class(i), to_string(static_cast<ExtractionStep>(i))});
  }
  return legend;
}

/// Spec 12's table 7.1 in our steps; normalisation there is without fusion.
constexpr StepTimes kSteps2005{0, 14.6, 4.6, 24.1, 4.8, 2.3, 66.2, 0, 9.1};

}  // namespace

std::string steps_plot(const BenchRun& run) {
  const std::size_t count = run.stepped.size();
  if (count == 0) return "";
  const std::size_t per_bar = (count + kMostBars - 1) / kMostBars;
  std::vector<StepTimes> bars;
  std::vector<double> heights = run.total_ms();
  for (std::size_t i = 0; i < count; i += per_bar) {
    const std::size_t end = std::min(count, i + per_bar);
    StepTimes mean{};
    for (std::size_t k = i; k < end; ++k) {
      for (std::size_t s = 0; s < mean.size(); ++s) {
        mean[s] += run.stepped[k].statistics.step_ms[s] / static_cast<double>(end - i);
      }
    }
    bars.push_back(mean);
    double height = 0;
    for (const double ms : mean) height += ms;
    heights.push_back(height);
  }
  SvgAxis x;
  x.high = static_cast<double>(count);
  x.label = per_bar == 1 ? "picture" : text_of("picture (a bar is the mean of %zu)", per_bar);
  SvgPlot plot(x, SvgAxis::around(heights, false, "ms per picture"));
  for (std::size_t b = 0; b < bars.size(); ++b) {
    const std::size_t first = b * per_bar;
    const double left = static_cast<double>(first), right = static_cast<double>(std::min(count, first + per_bar));
    std::string tip = run.pictures[run.stepped[first].picture];
    double top = 0;
    for (std::size_t s = 0; s < kExtractionSteps; ++s) {
      if (bars[b][s] > 0) tip += text_of("\n%s %.2f ms", to_string(static_cast<ExtractionStep>(s)), bars[b][s]);
    }
    plot.open_group(tip);
    const double gap = bars.size() > 120 ? 0 : 0.08 * (right - left);
    for (std::size_t s = 0; s < kExtractionSteps; ++s) {
      if (bars[b][s] <= 0) continue;
      plot.rectangle(left + gap, top, right - gap, top + bars[b][s], step_class(s));
      top += bars[b][s];
    }
    plot.close_group();
  }
  std::vector<double> at, total;
  for (std::size_t i = 0; i < run.totals.size(); ++i) {
    at.push_back(static_cast<double>(i) + 0.5);
    total.push_back(run.totals[i].total_ms);
  }
  std::vector<LegendEntry> legend = legend_of(summed_steps(run));
  if (!at.empty()) {
    plot.line(at, total, "total");
    legend.push_back({"total-swatch", "total, nothing waiting between"});
  }
  return figure("Steps of every picture: " + describe(run.request), plot.svg(), legend);
}

std::string distribution_plot(const std::vector<const BenchRun*>& runs) {
  std::vector<double> all;
  for (const BenchRun* run : runs) {
    const std::vector<double> ms = run->total_ms();
    all.insert(all.end(), ms.begin(), ms.end());
  }
  if (all.size() < 4) return "";
  std::ranges::sort(all);
  const bool wide = all.front() > 0 && all.back() / all.front() > 8;
  SvgAxis x = SvgAxis::around(all, wide, "ms per picture, nothing waiting between the steps");
  if (!wide) x.low = std::max(0.0, std::floor(all.front() - 0.15 * (all.back() - all.front())));
  const int bins = std::clamp(static_cast<int>(2 * std::sqrt(static_cast<double>(all.size()))), 8, kMostBins);
  const auto edge = [&](int bin) {
    const double part = static_cast<double>(bin) / bins;
    return wide ? x.low * std::pow(x.high / x.low, part) : x.low + part * (x.high - x.low);
  };
  std::vector<std::array<double, kMostBins>> shares(runs.size());
  std::vector<double> heights;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (const double ms : runs[r]->total_ms()) {
      const int bin = std::clamp(static_cast<int>(x.part(ms) * bins), 0, bins - 1);
      shares[r][static_cast<std::size_t>(bin)] += 100.0 / static_cast<double>(runs[r]->totals.size());
    }
    heights.insert(heights.end(), shares[r].begin(), shares[r].end());
  }
  SvgPlot plot(x, SvgAxis::around(heights, false, "% of the pictures"), 860, 240);
  std::vector<LegendEntry> legend;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (runs[r]->totals.empty()) continue;
    const Quantiles q = quantiles_of(runs[r]->total_ms());
    for (int bin = 0; bin < bins; ++bin) {
      const double share = shares[r][static_cast<std::size_t>(bin)];
      if (share > 0) plot.rectangle(edge(bin), 0, edge(bin + 1), share, run_class(r));
    }
    const double top = *std::ranges::max_element(heights);
    plot.line({q.median, q.median}, {0, top}, "median " + run_class(r) + "-line");
    legend.push_back(
        {run_class(r), text_of("%s: median %.2f ms, quartiles %.2f to %.2f, %zu pictures",
                               to_string(runs[r]->request.pipeline), q.median, q.lower, q.upper, q.count)});
  }
  return figure("How totals are distributed; dashed: the medians", plot.svg(), legend);
}

std::string shares_plot(const std::vector<const BenchRun*>& runs, bool with_2005) {
  std::vector<std::pair<std::string, StepTimes>> bars;
  if (with_2005) bars.emplace_back("2005", kSteps2005);
  for (const BenchRun* run : runs) {
    if (!run->stepped.empty()) bars.emplace_back(to_string(run->request.pipeline), summed_steps(*run));
  }
  if (bars.empty() || (with_2005 && bars.size() < 2)) return "";
  std::string rows;
  StepTimes used{};
  // Rows of a table rather than a y axis: their names are words.
  for (const auto& [name, times] : bars) {
    double all = 0;
    for (const double ms : times) all += ms;
    rows += "<tr><th>" + html_escaped(name) +
            "</th><td><svg class=\"bar\" viewBox=\"0 0 1000 34\" "
            "preserveAspectRatio=\"none\">";
    double left = 0;
    for (std::size_t s = 0; s < times.size() && all > 0; ++s) {
      used[s] += times[s];
      if (times[s] <= 0) continue;
      const double share = times[s] / all;
      rows += text_of(
          "<rect class=\"%s\" x=\"%.2f\" y=\"0\" width=\"%.2f\" height=\"34\"><title>%s %.1f %%</title></rect>",
          step_class(s).c_str(), 1000 * left, 1000 * share, to_string(static_cast<ExtractionStep>(s)), 100 * share);
      left += share;
    }
    rows += "</svg></td></tr>\n";
  }
  return figure("Where the time goes: each step's share", "<table class=\"shares\">" + rows + "</table>\n",
                legend_of(used), with_2005 ? "2005's \"other\" is mostly upload." : "");
}

std::string scaling_plot(const std::vector<const ScalingCurve*>& curves) {
  std::vector<double> all_x, all_y;
  for (const ScalingCurve* curve : curves) {
    for (const ScalingCurve::Point& point : curve->points) {
      all_x.push_back(point.x);
      all_y.insert(all_y.end(), {point.ms.lower, point.ms.median, point.ms.upper});
    }
  }
  if (all_x.size() < 2) return "";
  // With room below, so that the ideal can be seen falling.
  all_y.push_back(0.4 * *std::ranges::min_element(all_y));
  const SvgAxis y_axis = SvgAxis::around(all_y, true, "ms per picture");
  SvgPlot plot(SvgAxis::around(all_x, true, curves.front()->x_label), y_axis, 860, 340);
  std::vector<LegendEntry> legend;
  std::string notes;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const ScalingCurve& curve = *curves[c];
    if (curve.points.size() < 2) continue;
    const std::string css = run_class(c);
    std::vector<double> x, y;
    for (const ScalingCurve::Point& point : curve.points) {
      x.push_back(point.x);
      y.push_back(point.ms.median);
      plot.line({point.x, point.x}, {point.ms.lower, point.ms.upper}, "spread " + css + "-line");
    }
    // What is proportional to x, through the last point, as far down as the plot reaches.
    const ScalingCurve::Point& last = curve.points.back();
    const double from = std::max(curve.points.front().x, last.x * y_axis.low / last.ms.median);
    plot.line({from, last.x}, {last.ms.median * from / last.x, last.ms.median}, "ideal " + css + "-line");
    plot.line(x, y, "curve " + css + "-line");
    for (const ScalingCurve::Point& point : curve.points) {
      plot.dot(point.x, point.ms.median, css,
               text_of("%.6g: %.2f ms (%.2f to %.2f)", point.x, point.ms.median, point.ms.lower, point.ms.upper));
    }
    legend.push_back({css, text_of("%s: t = %.3g %+.3g x; t ~ x^%.2f, at the end x^%.2f: %s", to_string(curve.pipeline),
                                   curve.fit.constant, curve.fit.slope, curve.fit.exponent, curve.fit.exponent_at_end,
                                   curve.fit.at_most_linear ? "at most linear" : "more than linear")});
  }
  return figure("By " + curves.front()->title, plot.svg(), legend,
                "Points: medians, bars: quartiles; dashed: proportional to x, through the last point.");
}

}  // namespace foreview
