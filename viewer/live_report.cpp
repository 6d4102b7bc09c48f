#include "foreview/viewer/live_report.h"

#include <nlohmann/json.hpp>

#include "foreview/viewer/formatted.h"

namespace foreview {
namespace {

double ms(Duration duration) {
  return static_cast<double>(duration.nanoseconds) * 1e-6;
}

const char* name_of(ClockMode mode) {
  return mode == ClockMode::synchronised ? "synchronised" : "estimated";
}

}  // namespace

nlohmann::ordered_json to_json(const LiveReport& report) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const LiveReport::Camera& camera : report.cameras) {
    cameras.push_back({{"name", camera.name},
                       {"topic", camera.topic},
                       {"pictures_in", camera.counts.in},
                       {"pictures_used", camera.counts.used},
                       {"pictures_overwritten", camera.counts.overwritten},
                       {"pictures_damaged", camera.counts.damaged},
                       {"pictures_stateless", camera.counts.stateless},
                       {"pictures_duplicated", camera.counts.duplicated},
                       {"pictures_lost_on_link", camera.counts.lost},
                       {"pictures_lost_on_network", camera.lost_on_network}});
  }
  const LiveSource::Latency& latency = report.latency;
  return {{"cameras", cameras},
          {"latency_ms",
           {{"capture_to_arrival_median", ms(latency.transport_median)},
            {"arrival_to_available_median", ms(latency.median)},
            {"arrival_to_available_p99", ms(latency.p99)},
            {"capture_to_display_median", ms(report.display_median)},
            {"capture_to_display_p99", ms(report.display_p99)}}},
          {"clock",
           {{"mode", name_of(latency.clock_mode)},
            {"uncertainty_ms", ms(latency.clock_uncertainty)},
            {"drift_ppm", latency.drift * 1e6},
            {"jumps", latency.clock_jumps},
            {"warning", latency.clock_warning}}},
          {"missing", report.missing}};
}

std::string to_text(const LiveReport& report) {
  std::string text;
  for (const LiveReport::Camera& camera : report.cameras) {
    const PictureCounts& counts = camera.counts;
    text +=
        camera.name +
        formatted(": %zu in, %zu used, %zu overwritten, %zu damaged, %zu without state, %zu duplicated, %zu lost | ",
                  counts.in, counts.used, counts.overwritten, counts.damaged, counts.stateless, counts.duplicated,
                  counts.lost + camera.lost_on_network);
  }
  if (report.displayed > 0) {
    text += formatted("capture to display: median %.0f ms, p99 %.0f ms (clock %s)", ms(report.display_median),
                      ms(report.display_p99), name_of(report.latency.clock_mode));
  } else {
    text += "nothing displayed yet";
  }
  if (!report.missing.empty()) text += " | " + report.missing;
  return text;
}

}  // namespace foreview
