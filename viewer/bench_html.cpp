#include "foreview/viewer/bench_html.h"

#include <string>
#include <vector>

#include "foreview/viewer/bench_plots.h"
#include "foreview/viewer/run_counters.h"

namespace foreview {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --back: #fbfbfa; --card: #ffffff; --ink: #23272e; --soft: #6b7280; --line: #e3e5e8;
  --sum: #f3f4f6; --r0: #2f6fb3; --r1: #d9772b; --r2: #3d9970; --r3: #8e5ea8; }
@media (prefers-color-scheme: dark) {
  :root { --back: #16181c; --card: #1e2126; --ink: #e4e6ea; --soft: #9aa1ac; --line: #33373e; --sum: #262a30;
    --r0: #6ea8e6; --r1: #f0a35e; --r2: #63c49b; --r3: #bf95d6; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 1080px; background: var(--back); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.6rem; margin: 0 0 .25rem; } h2 { font-size: 1.2rem; margin: 2.2rem 0 .6rem; }
h3 { font-size: 1rem; margin: 1.6rem 0 .4rem; }
.machine { color: var(--soft); white-space: pre-line; margin: 0 0 1rem; font-size: .87rem; }
.warning { border-left: 4px solid var(--r1); padding: .4rem .8rem; background: var(--card); }
.findings { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: .7rem 1rem .7rem 2rem; }
figure { background: var(--card); border: 1px solid var(--line); border-radius: 8px; margin: 1rem 0;
  padding: .9rem 1rem .6rem; }
figcaption { font-weight: 600; margin-bottom: .3rem; }
figure > svg { display: block; width: 100%; height: auto; }
.scroll { overflow-x: auto; background: var(--card); border: 1px solid var(--line); border-radius: 8px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .8rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
tbody tr:last-child > * { border-bottom: 0; }
th:first-child { text-align: left; font-weight: 500; } thead th { color: var(--soft); font-weight: 600; }
tr.sum > * { background: var(--sum); font-weight: 600; }
small { color: var(--soft); font-weight: 400; }
.note, pre { color: var(--soft); font-size: .85rem; margin: .3rem 0; }
.shares th { width: 7rem; border: 0; } .shares td { padding: .15rem 0; border: 0; }
.bar { display: block; width: 100%; height: 30px; }
.legend { font-size: .85rem; margin: .4rem 0 .2rem; } .legend span { margin-right: 1.1rem; white-space: nowrap; }
.swatch { width: 11px; height: 11px; margin-right: .4em; vertical-align: -1px; }
.text { font-size: 12px; fill: var(--soft); } .label { font-size: 12.5px; fill: var(--ink); }
.grid { stroke: var(--line); } .axis { stroke: var(--soft); }
polyline { fill: none; stroke-linejoin: round; }
.total { stroke: var(--ink); stroke-width: 1.6; } .total-swatch { fill: var(--ink); }
.curve { stroke-width: 2; } .spread { stroke-width: 5; stroke-opacity: .35; stroke-linecap: round; }
.ideal { stroke-width: 1.3; stroke-dasharray: 5 4; } .median { stroke-width: 1.8; stroke-dasharray: 4 3; }
rect.r0, rect.r1, rect.r2, rect.r3 { fill-opacity: .72; }
.r0 { fill: var(--r0); } .r1 { fill: var(--r1); } .r2 { fill: var(--r2); } .r3 { fill: var(--r3); }
.r0-line { stroke: var(--r0); } .r1-line { stroke: var(--r1); } .r2-line { stroke: var(--r2); } .r3-line { stroke: var(--r3); }
.s0 { fill: #8fa3b8; } .s1 { fill: #4e79a7; } .s2 { fill: #f28e2b; } .s3 { fill: #e15759; } .s4 { fill: #76b7b2; }
.s5 { fill: #b07aa1; } .s6 { fill: #59a14f; } .s7 { fill: #d8b52c; } .s8 { fill: #a59c97; }
)";

/// Runs that were measured both ways: those that plots of single pictures are about.
std::vector<const BenchRun*> plotted_runs(const BenchReport& report) {
  std::vector<const BenchRun*> runs;
  if (report.kind == "scaling") return runs;
  for (const BenchRun& run : report.runs) {
    if (run.request.totals && run.request.steps && !run.stepped.empty()) runs.push_back(&run);
  }
  return runs;
}

std::string plots_of_runs(const BenchReport& report) {
  const std::vector<const BenchRun*> runs = plotted_runs(report);
  std::string html = shares_plot(runs, report.kind == "tables");
  for (const BenchRun* run : runs) html += steps_plot(*run);
  return html + distribution_plot(runs);
}

std::string plots_of_curves(const BenchReport& report) {
  std::string html;
  for (const ScalingCurve& first : report.curves) {
    std::vector<const ScalingCurve*> same;
    for (const ScalingCurve& curve : report.curves) {
      if (curve.id == first.id) same.push_back(&curve);
    }
    if (same.front() == &first) html += scaling_plot(same);
  }
  return html;
}

}  // namespace

std::string report_html(const BenchReport& report) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>foreview bench: " +
      html_escaped(report.title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" +
      html_escaped(report.title) + "</h1>\n<p class=\"machine\">" +
      html_escaped(machine_text(report.machine) + report.machine.started) + "</p>\n";
  if (!report.complete) html += "<p class=\"warning\">Interrupted: only what was measured until then.</p>\n";
  if (!report.findings.empty()) {
    html += "<ul class=\"findings\">\n";
    for (const std::string& finding : report.findings) html += "<li>" + html_escaped(finding) + "</li>\n";
    html += "</ul>\n";
  }
  const std::string plots = plots_of_runs(report) + plots_of_curves(report);
  if (!plots.empty()) html += "<h2>Plots</h2>\n" + plots;
  if (!report.tables.empty()) html += "<h2>Tables</h2>\n";
  for (const BenchTable& table : report.tables) html += table_html(table);
  if (report.with_counters) {
    for (const BenchRun& run : report.runs) {
      if (!run.request.counting || !run.unsupported.empty()) continue;
      html += "<h3>" + html_escaped(describe(run.request)) + "</h3>\n<pre>" +
              html_escaped(counters_text(run.counters)) + "</pre>\n";
    }
  }
  return html + "</body>\n</html>\n";
}

}  // namespace foreview
