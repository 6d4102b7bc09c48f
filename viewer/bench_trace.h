#pragma once
#include <string>

#include "foreview/viewer/bench_report.h"

namespace foreview {

/// Chrome's trace-event format (JSON object with "traceEvents"), as ui.perfetto.dev and chrome://tracing open it: a
/// process per run, in it a track "CPU" with the issuing and a track "GPU" with the carrying out of every step of every
/// picture, and "pictures" with each picture as a whole. Times in microseconds since the benchmark's start. Only runs
/// whose spans were kept.
[[nodiscard]] std::string report_trace(const BenchReport& report);

}  // namespace foreview
