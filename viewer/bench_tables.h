#pragma once
#include <functional>
#include <string>
#include <vector>

#include "foreview/viewer/bench_report.h"

namespace foreview {

/// A scene that tables are measured on, with its pictures.
struct BenchSubject {
  std::string name;
  const PolygonModel* model = nullptr;
  ChartOptions charts;  ///< page size and memory budget; density and max_texels come from the tables
  /// The pictures, `count` of them spread evenly.
  std::function<BenchPictures(std::size_t count)> pictures;
};

struct TablesOptions {
  std::vector<PipelineKind> pipelines{PipelineKind::batched};
  std::size_t pictures = 0;  ///< per measurement; 0: kTablesPictures of the pipeline
  double density = 1;        ///< all densities and largest textures of the tables times this: 1, or less for a trial
  Publishing publishing = Publishing::direct;
  bool keep_spans = false;  ///< of tables 7.1's runs
  bool counting = false;
};
[[nodiscard]] std::size_t default_table_pictures(PipelineKind pipeline);
/// The iterative filling of the per-polygon pipeline takes so long that it is measured with no more pictures than this.
inline constexpr std::size_t kIterativePictures = 2;
/// ... and nothing begins another picture after so many seconds.
inline constexpr double kSecondsPerRun = 60;

/// Tables 7.1-7.4 of spec 12. `complex`, `object`, `cube` are the three scenes of table 7.3; the other tables are about
/// `complex`. Fills report.runs, and report.tables with what is there at any time, also when `progress` (done, todo
/// pictures) throws Interrupted.
void measure_tables(const BenchSubject& complex, const BenchSubject& object, const BenchSubject& cube,
                    const TablesOptions& options, BenchReport& report,
                    const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace foreview
