#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/viewer/bench_pictures.h"
#include "foreview/viewer/run_counters.h"

namespace foreview {

/// One picture of a run without per-step waits: what it costs in earnest.
struct PictureCost {
  std::size_t picture = 0;          ///< of BenchRun::pictures
  double start_ms = 0;              ///< since the benchmark's start
  double total_ms = 0;              ///< wall clock from the call to the end of one glFinish after it
  double cpu_ms = 0;                ///< of that, until the call returned
  double decode_ms = 0;             ///< beforehand, not in total_ms
  ExtractionStatistics statistics;  ///< without times
};

/// One picture of a run with every step timed.
struct SteppedCost {
  std::size_t picture = 0;
  double start_ms = 0;              ///< since the benchmark's start
  ExtractionStatistics statistics;  ///< with times; spans only where they are kept
};

inline constexpr std::size_t kWarmUpPictures = 2;  ///< usually extracted before each measurement, and not counted

/// What is to be measured.
struct BenchRequest {
  std::string subject;  ///< the recording's or scene's name
  PipelineKind pipeline = PipelineKind::batched;
  ExtractionOptions extraction;
  ChartOptions charts;
  Publishing publishing = Publishing::direct;
  bool totals = true;       ///< measure what pictures cost without per-step waits
  bool steps = true;        ///< measure the steps, in a run of their own
  bool keep_spans = false;  ///< for a trace
  std::size_t warm_up = kWarmUpPictures;
  double seconds = 0;     ///< after so long neither run begins another picture; 0: all
  bool counting = false;  ///< count observed texels, in a run of its own
};

/// What was measured. After Interrupted it holds what was measured until then.
struct BenchRun {
  BenchRequest request;
  std::string unsupported;  ///< why this pipeline refuses these options; empty: it takes them
  std::string camera;
  int width = 0, height = 0;  ///< pixels
  std::vector<std::string> pictures;
  std::vector<PictureCost> totals;
  std::vector<SteppedCost> stepped;
  ExtractionTiming step_timing = ExtractionTiming::off;  ///< `queries` only where timer_queries_are_truthful()
  RunCounters counters;                                  ///< of the run without per-step waits, else the stepped one
  bool complete = false;

  [[nodiscard]] std::vector<double> total_ms() const;
  [[nodiscard]] std::vector<double> step_ms(ExtractionStep step) const;
  [[nodiscard]] std::vector<double> stepped_total_ms() const;
  /// Milliseconds of each picture of `totals` that wrote any texel, per million texels written.
  [[nodiscard]] std::vector<double> ms_per_million_texels() const;
};

/// Measures with the given pictures, beginning with empty textures; damaged ones are counted and left out. `run` must
/// be empty; it is filled as the work goes on. `tick` is called before every picture and may throw Interrupted, which
/// passes through. Needs a current GL context.
void measure(const BenchRequest& request, TextureStore& store, BenchPictures& pictures, BenchRun& run,
             const std::function<void()>& tick = {});

/// A store laid out as the request says, within its memory budget with all sets of textures.
[[nodiscard]] std::unique_ptr<TextureStore> make_store(const PolygonModel& model, const BenchRequest& request);

/// Pictures that measure() extracts, for a progress bar.
[[nodiscard]] std::size_t pictures_to_extract(const BenchRequest& request, std::size_t pictures);

/// The store's options for a pipeline: only the batched one takes several polygons in a chart.
[[nodiscard]] ChartOptions charts_for(PipelineKind pipeline, ChartOptions charts);

/// Milliseconds since the benchmark's start: the first call.
[[nodiscard]] double bench_clock_ms();

}  // namespace foreview
