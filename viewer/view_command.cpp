#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/key_map.h"
#include "foreview/viewer/replay_options_cli.h"
#include "foreview/viewer/viewer_session.h"

namespace foreview {
namespace {

void write_json(const std::filesystem::path& file, const ViewerSummary& summary) {
  const SourceStatus& source = summary.source;
  const nlohmann::ordered_json json{
      {"format", "foreview-view"},
      {"version", 1},
      {"recording", summary.recording},
      {"camera", summary.camera},
      {"from_seconds", summary.from_seconds},
      {"to_seconds", summary.to_seconds},
      {"pictures_written", summary.pictures_written},
      {"pictures_extracted", summary.counters.pictures_extracted},
      {"pictures_in", source.pictures_in},
      {"pictures_used", source.used},
      {"pictures_overwritten", source.overwritten},
      {"pictures_damaged", source.damaged},
      {"pictures_lost", source.lost},
      {"frames", summary.frames},
      {"frames_late", summary.frames_late},
      {"frames_skipped", summary.frames_skipped},
      {"frames_missed", summary.frames_missed},
      {"contexts_lost", summary.contexts_lost},
  };
  write_file_whole(file, json.dump(2) + "\n");
}

}  // namespace

void run_viewer(const ViewerOptions& options, bool quiet) {
  if (!quiet) std::cout << key_table_text() << std::flush;
  const ViewerSummary summary = view_recording(options);
  if (summary.source.damaged > 0) {
    spdlog::warn("{} picture(s) could not be read and were left out", summary.source.damaged);
  }
  if (options.replay.stats) std::cout << counters_text(summary.counters) << std::flush;
  if (options.json) write_json(*options.json, summary);
  throw_if_interrupted();
}

}  // namespace foreview
