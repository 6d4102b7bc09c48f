#pragma once
#include <deque>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "foreview/viewer/bench_measurement.h"
#include "foreview/viewer/bench_statistics.h"
#include "foreview/viewer/bench_table.h"

namespace foreview {

/// What the figures hold for.
struct BenchMachine {
  std::string renderer, gl_version;
  std::string cpu;  ///< its name, where the system tells
  unsigned cpus = 0;
  bool timer_queries = false;  ///< truthful here: steps are timed by them, else by glFinish and the wall clock
  std::vector<std::string> timer_check;  ///< what the start-up test found, one line per kind of work
  std::string started;                   ///< UTC, ISO 8601
};
/// Of the current context.
[[nodiscard]] BenchMachine describe_machine();

/// How the cost grows with one size, the others kept.
struct ScalingCurve {
  std::string id;  ///< "polygons", "pixels", "texels"
  std::string title;
  std::string x_label;
  PipelineKind pipeline = PipelineKind::batched;
  struct Point {
    double x = 0;
    Quantiles ms;
    std::size_t run = 0;  ///< index into BenchReport::runs
  };
  std::vector<Point> points;  ///< ascending x
  GrowthFit fit;              ///< of the medians; where there are at least two points
  [[nodiscard]] bool has_fit() const { return points.size() >= 2; }
};

/// A whole benchmark: what is printed and written. Runs stay where they are as more are added.
struct BenchReport {
  std::string kind;  ///< "tables", "scaling" or "recording"
  std::string title;
  BenchMachine machine;
  std::vector<std::pair<std::string, std::string>> options;  ///< as given
  std::deque<BenchRun> runs;
  std::vector<BenchTable> tables;
  std::vector<ScalingCurve> curves;
  std::vector<std::string> findings;  ///< one line each
  bool with_counters = false;         ///< --stats
  bool complete = false;
};

inline constexpr int kBenchJsonVersion = 1;

/// Two or three lines: renderer, timer method.
[[nodiscard]] std::string machine_text(const BenchMachine& machine);
/// Everything after the machine's lines: tables, curves' findings, counters.
[[nodiscard]] std::string report_text(const BenchReport& report);
/// One JSON object: "format" "foreview-bench", "version" kBenchJsonVersion; described in docs/benchmark.md.
[[nodiscard]] std::string report_json(const BenchReport& report);
/// "2 passes of diamond, pyramid, d 500, r_max 256, batched".
[[nodiscard]] std::string describe(const BenchRequest& request);

}  // namespace foreview
