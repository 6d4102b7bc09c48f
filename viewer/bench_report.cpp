#include "foreview/viewer/bench_report.h"

#include <epoxy/gl.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "foreview/gpu/timer_queries.h"
#include "foreview/viewer/extraction_names.h"

namespace foreview {
namespace {

using Json = nlohmann::ordered_json;

template <typename... Values>
std::string text_of(const char* format, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string gl_string(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text != nullptr ? text : "";
}

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

const char* name_of(ExtractionTiming timing) {
  return timing == ExtractionTiming::queries ? "queries" : timing == ExtractionTiming::finish ? "finish" : "off";
}

Json json_of(const Quantiles& q) {
  if (q.count == 0) return nullptr;
  return {{"count", q.count},   {"least", q.least},          {"lower_quartile", q.lower},
          {"median", q.median}, {"upper_quartile", q.upper}, {"greatest", q.greatest}};
}

Json json_of(const std::array<double, kExtractionSteps>& step_ms) {
  Json steps;
  for (std::size_t i = 0; i < kExtractionSteps; ++i) steps[to_string(static_cast<ExtractionStep>(i))] = step_ms[i];
  return steps;
}

Json json_of(const BenchRequest& request) {
  const ExtractionOptions& e = request.extraction;
  return {{"subject", request.subject},
          {"pipeline", to_string(request.pipeline)},
          {"artefacts", to_string(e.artefacts)},
          {"passes", e.passes},
          {"alpha_c", e.alpha_c},
          {"small_texture", e.small_texture},
          {"fill", to_string(e.fill)},
          {"occlusion_query", e.occlusion_query},
          {"exposure", auto_or_off(e.compensate_exposure)},
          {"near", e.near_plane},
          {"density", request.charts.texels_per_metre},
          {"max_texels", request.charts.max_texels},
          {"warm_up_pictures", request.warm_up}};
}

Json json_of(const BenchRun& run, bool with_counters) {
  Json json = json_of(run.request);
  json["complete"] = run.complete;
  json["unsupported"] = run.unsupported.empty() ? Json(nullptr) : Json(run.unsupported);
  json["camera"] = run.camera;
  json["width"] = run.width;
  json["height"] = run.height;
  json["step_timing"] = name_of(run.step_timing);
  json["total_ms"] = json_of(quantiles_of(run.total_ms()));
  json["ms_per_million_texels"] = json_of(quantiles_of(run.ms_per_million_texels()));
  json["totals"] = Json::array();
  for (const PictureCost& cost : run.totals) {
    json["totals"].push_back({{"picture", run.pictures[cost.picture]},
                              {"start_ms", cost.start_ms},
                              {"total_ms", cost.total_ms},
                              {"cpu_ms", cost.cpu_ms},
                              {"decode_ms", cost.decode_ms},
                              {"texels_written", cost.statistics.texels_written},
                              {"polygons_visible", cost.statistics.polygons_visible},
                              {"passes", cost.statistics.passes},
                              {"draw_calls", cost.statistics.draw_calls}});
  }
  json["stepped"] = Json::array();
  for (const SteppedCost& cost : run.stepped) {
    json["stepped"].push_back({{"picture", run.pictures[cost.picture]},
                               {"start_ms", cost.start_ms},
                               {"total_ms", cost.statistics.total_ms},
                               {"steps_ms", json_of(cost.statistics.step_ms)}});
  }
  if (with_counters) json["counters"] = counters_json(run.counters);
  return json;
}

Json json_of(const ScalingCurve& curve) {
  Json points = Json::array();
  for (const ScalingCurve::Point& point : curve.points) {
    points.push_back({{"x", point.x}, {"ms", json_of(point.ms)}, {"run", point.run}});
  }
  Json json{{"id", curve.id},
            {"title", curve.title},
            {"x_label", curve.x_label},
            {"pipeline", to_string(curve.pipeline)},
            {"points", std::move(points)},
            {"fit", nullptr}};
  if (curve.has_fit()) {
    json["fit"] = {{"constant_ms", curve.fit.constant},
                   {"slope_ms", curve.fit.slope},
                   {"exponent", curve.fit.exponent},
                   {"exponent_at_end", curve.fit.exponent_at_end},
                   {"at_most_linear", curve.fit.at_most_linear}};
  }
  return json;
}

}  // namespace

BenchMachine describe_machine() {
  BenchMachine machine;
  machine.renderer = gl_string(GL_RENDERER);
  machine.gl_version = gl_string(GL_VERSION);
  machine.cpu = cpu_name();
  machine.cpus = std::thread::hardware_concurrency();
  machine.started = utc_now();
  machine.timer_queries = timer_queries_are_truthful();
  for (const TimerCheck::Work& work : startup_timer_check().works) {
    machine.timer_check.push_back(
        text_of("%s: %.2f ms on the wall clock, %.2f ms by queries", work.kind, work.wall_ms, work.query_ms));
  }
  return machine;
}

std::string machine_text(const BenchMachine& machine) {
  std::string text = "GL: " + machine.renderer + ", " + machine.gl_version + "\n";
  text += text_of("CPU: %s%s%u CPUs\n", machine.cpu.c_str(), machine.cpu.empty() ? "" : ", ", machine.cpus);
  text += machine.timer_queries ? "timing: steps by GL timer queries (found truthful), totals by glFinish + wall clock"
                                : "timing: glFinish + wall clock (GL timer queries are not truthful here)";
  text += "\n";
  for (const std::string& line : machine.timer_check) text += "  " + line + "\n";
  return text;
}

std::string report_text(const BenchReport& report) {
  std::string text;
  for (const BenchTable& table : report.tables) text += table_text(table) + "\n";
  for (const std::string& finding : report.findings) text += finding + "\n";
  if (report.with_counters) {
    for (const BenchRun& run : report.runs) {
      if (!run.unsupported.empty() || !run.request.counting) continue;
      text += "\n" + describe(run.request) + ": " + counters_text(run.counters);
    }
  }
  std::string refused;
  for (const BenchRun& run : report.runs) {
    if (run.unsupported.empty() || refused.find(run.unsupported) != std::string::npos) continue;
    refused += std::string("- with ") + to_string(run.request.pipeline) + ": " + run.unsupported + "\n";
  }
  return text + refused;
}

std::string report_json(const BenchReport& report) {
  const BenchMachine& machine = report.machine;
  Json json{{"format", "foreview-bench"},
            {"version", kBenchJsonVersion},
            {"kind", report.kind},
            {"title", report.title},
            {"complete", report.complete},
            {"machine",
             {{"renderer", machine.renderer},
              {"gl_version", machine.gl_version},
              {"cpu", machine.cpu},
              {"cpus", machine.cpus},
              {"timer_method", machine.timer_queries ? "queries" : "finish"},
              {"timer_check", machine.timer_check},
              {"started", machine.started}}},
            {"options", Json::object()}};
  for (const auto& [name, value] : report.options) json["options"][name] = value;
  json["findings"] = report.findings;
  json["tables"] = Json::array();
  for (const BenchTable& table : report.tables) json["tables"].push_back(table_json(table));
  json["curves"] = Json::array();
  for (const ScalingCurve& curve : report.curves) json["curves"].push_back(json_of(curve));
  json["runs"] = Json::array();
  for (const BenchRun& run : report.runs) json["runs"].push_back(json_of(run, report.with_counters));
  return json.dump(1) + "\n";
}

std::string describe(const BenchRequest& request) {
  const ExtractionOptions& e = request.extraction;
  std::string text = request.subject + ", " + to_string(request.pipeline);
  text += e.artefacts == ArtefactSuppression::none ? ", no suppression"
                                                   : text_of(", %d %s passes", e.passes, to_string(e.artefacts));
  text += std::string(", ") + to_string(e.fill);
  if (e.fill == HoleFilling::iterative) text += e.occlusion_query ? " with query" : " without query";
  return text + text_of(", d %g, r_max %d", request.charts.texels_per_metre, request.charts.max_texels);
}

}  // namespace foreview
