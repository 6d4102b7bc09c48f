#pragma once
#include <functional>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/recordings/recording.h"
#include "foreview/viewer/bench_report.h"

namespace foreview {

struct DisplayBenchOptions {
  std::size_t camera = 0;
  ChartOptions charts;
  double seconds = 6;  ///< for each figure
  int width = 800, height = 600;
};

/// Table 7.5 of spec 12: what a picture takes beside a display of 25 to 100 frames a second, and which rate the display
/// reaches, with the batched pipeline; of a view with few polygons and of one with many, which are the recorded places
/// where fewest and most polygons are seen. Appends to report.tables also when `progress` (done, todo runs) throws
/// Interrupted. `context` must be current.
void measure_display_table(Recording& recording, const PolygonModel& model, OffscreenContext& context,
                           const DisplayBenchOptions& options, BenchReport& report,
                           const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace foreview
