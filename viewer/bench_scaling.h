#pragma once
#include <functional>
#include <string>
#include <vector>

#include "foreview/viewer/bench_report.h"

namespace foreview {

struct ScalingOptions {
  std::vector<PipelineKind> pipelines{PipelineKind::batched};
  std::size_t pictures = 0;  ///< per point; 0: default_scaling_pictures()
  std::size_t most_polygons = 100'000;
  double most_megapixels = 8.3;
  double point_seconds = 60;  ///< a curve ends before a point that the points so far let expect to take longer
  Publishing publishing = Publishing::direct;
  bool keep_spans = false;
  bool counting = false;
};
[[nodiscard]] std::size_t default_scaling_pictures(PipelineKind pipeline);

/// How the cost of a picture grows in a generated room (bench_scene.h), one size at a time: with the number of polygons
/// at equal texels, with the picture's size, and with the texels that the density makes. Then twice the polygons at
/// equal texels, in turn. Fills report.runs, curves, tables and findings, with what is there also when `tick(point)`,
/// called before every picture, throws Interrupted.
void measure_scaling(const ScalingOptions& options, BenchReport& report,
                     const std::function<void(const std::string& point)>& tick);

/// The density at which the room's layout has about so many texels to write: within 2 % where charts allow, tried with
/// a few layouts.
[[nodiscard]] double density_for_texels(const PolygonModel& model, ChartOptions charts, double texels);

/// "polygons, batched: 108 to 99372, t = 12.3 ms + 0.045 ms per 1000 polygons, ..."
[[nodiscard]] std::string finding_of(const ScalingCurve& curve);

}  // namespace foreview
