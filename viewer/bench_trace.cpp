#include "foreview/viewer/bench_trace.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace foreview {
namespace {

using Json = nlohmann::ordered_json;

enum Track { kPictures = 1, kCpu = 2, kGpu = 3 };

Json name_event(const char* what, std::size_t process, int thread, const std::string& name) {
  return {{"ph", "M"}, {"name", what}, {"pid", process}, {"tid", thread}, {"args", {{"name", name}}}};
}

Json span_event(const std::string& name, const char* category, std::size_t process, int thread, double begin_ms,
                double end_ms) {
  return {{"ph", "X"},
          {"name", name},
          {"cat", category},
          {"pid", process},
          {"tid", thread},
          {"ts", begin_ms * 1e3},
          {"dur", std::max(0.0, end_ms - begin_ms) * 1e3}};
}

}  // namespace

std::string report_trace(const BenchReport& report) {
  Json events = Json::array();
  std::size_t process = 0;
  for (const BenchRun& run : report.runs) {
    if (!run.request.keep_spans || run.stepped.empty()) continue;
    ++process;
    events.push_back(name_event("process_name", process, 0, describe(run.request)));
    events.push_back(name_event("thread_name", process, kPictures, "pictures"));
    events.push_back(name_event("thread_name", process, kCpu, "CPU"));
    events.push_back(name_event("thread_name", process, kGpu, "GPU"));
    for (const SteppedCost& cost : run.stepped) {
      const std::vector<StepSpan>& spans = cost.statistics.spans;
      if (spans.empty()) continue;
      Json picture = span_event(run.pictures[cost.picture], "picture", process, kPictures, cost.start_ms,
                                cost.start_ms + std::max(spans.back().gpu_end, spans.back().cpu_end));
      picture["args"] = {{"polygons_visible", cost.statistics.polygons_visible},
                         {"texels_written", cost.statistics.texels_written}};
      events.push_back(std::move(picture));
      for (const StepSpan& span : spans) {
        const char* name = to_string(span.step);
        events.push_back(
            span_event(name, "cpu", process, kCpu, cost.start_ms + span.cpu_begin, cost.start_ms + span.cpu_end));
        events.push_back(
            span_event(name, "gpu", process, kGpu, cost.start_ms + span.gpu_begin, cost.start_ms + span.gpu_end));
      }
    }
  }
  const Json trace{{"displayTimeUnit", "ms"},
                   {"otherData",
                    {{"format", "foreview-bench-trace"},
                     {"renderer", report.machine.renderer},
                     {"timer_method", report.machine.timer_queries ? "queries" : "finish"}}},
                   {"traceEvents", std::move(events)}};
  return trace.dump() + "\n";
}

}  // namespace foreview
