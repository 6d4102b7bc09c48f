#pragma once
#include <string>

#include "foreview/viewer/bench_report.h"

namespace foreview {

/// One HTML page with the report's tables and its plots as inline SVG; no script, no other file, no network.
[[nodiscard]] std::string report_html(const BenchReport& report);

}  // namespace foreview
