#pragma once
#include <functional>
#include <vector>

#include "foreview/viewer/bench_report.h"
#include "foreview/viewer/replayer.h"

namespace foreview {

struct RecordingBenchOptions {
  ReplayOptions replay;  ///< recording, scene, camera, from, to, extraction, density, max_texels
  std::vector<PipelineKind> pipelines{PipelineKind::batched};
  std::size_t pictures = 0;  ///< spread evenly over from..to; 0: all for the batched pipeline, 20 for the other
  Publishing publishing = Publishing::direct;
  bool keep_spans = false;
  bool counting = false;
};

/// The steps on one's own recording: one table, one run per pipeline, and the pictures a second that it reaches with
/// and without decoding. Fills `report` also when `progress` (done, todo pictures) throws Interrupted. InputError where
/// the recording cannot be used or a pipeline refuses the options.
void measure_recording(const RecordingBenchOptions& options, BenchReport& report,
                       const std::function<void(std::size_t, std::size_t)>& progress);

/// The table of all steps: a median [quartiles] and a share for each run that was measured.
[[nodiscard]] BenchTable steps_table_of(const std::vector<const BenchRun*>& runs, const std::string& title);

}  // namespace foreview
