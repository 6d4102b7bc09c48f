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
#include "foreview/viewer/link_options_cli.h"
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
      {"first_frame_after_seconds", summary.first_frame_after.seconds()},
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
      {"objects_grown", summary.objects_grown},
      {"objects_left", summary.objects_left},
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

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  foreview view workcell\n"
    "  foreview view workcell --delay 800ms --jitter 100ms --loss 10% --view split";

struct ViewCommand {
  ViewerOptions options;
  std::string view = "predicted";
};

void run(const ViewCommand& given, bool quiet) {
  ViewerOptions options = given.options;
  const std::optional<ViewMode> mode = parse_view_mode(given.view);
  if (!mode) {
    throw InputError("--view",
                     "\"" + given.view + "\" is not known; expected predicted, delayed, both, split or difference");
  }
  options.session.choice.mode = *mode;
  options.link.delay = options.replay.delay;
  const double speed = options.session.speed;
  if (!(speed >= 0.01 && speed <= 100)) throw InputError("--speed", "expected a factor from 0.01 to 100");
  if (options.rate && !(*options.rate >= 1 && *options.rate <= 500)) {
    throw InputError("--rate", "expected 1 to 500 frames a second");
  }
  run_viewer(options, quiet);
}

}  // namespace

void add_view_command(CLI::App& app) {
  CLI::App* view =
      app.add_subcommand("view", "Look at a recording as if it came in live, in a window with all controls");
  const auto command = std::make_shared<ViewCommand>();
  ViewerOptions& options = command->options;
  add_replay_options(*view, options.replay);
  add_pipeline_options(*view, options.replay);
  add_link_options(*view, options.link);
  view->add_option("--speed", options.session.speed, "Recorded seconds per second (default: 1)")->type_name("FACTOR");
  view->add_flag("--loop", options.session.loop, "Begin anew at the end");
  view->add_option("--view", command->view, "predicted, delayed, both, split or difference (default: predicted)")
      ->type_name("VIEW");
  view->add_option("--rate", options.rate, "Frames a second (default: the monitor's up to 60; 33 where the CPU draws)")
      ->type_name("HZ");
  view->add_flag("!--no-panels", options.panels, "Begin with the panels hidden");
  view->add_option("--out", options.session.out, "Where pictures are saved (default: where you are)")->type_name("DIR");
  view->add_option("--json", options.json, "Write what was done to this file")->type_name("FILE");
  view->footer(kExamples + std::string("\n\n") + key_table_text());
  view->callback([command, &app] { run(*command, app.count("--quiet") > 0); });
}

}  // namespace foreview
