#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <array>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/key_map.h"
#include "foreview/viewer/link_options_cli.h"
#include "foreview/viewer/live_headless.h"
#include "foreview/viewer/live_options_cli.h"
#include "foreview/viewer/registration_report.h"
#include "foreview/viewer/replay_options_cli.h"
#include "foreview/viewer/view_options_cli.h"
#include "foreview/viewer/viewer_session.h"

namespace foreview {
namespace {

void write_json(const std::filesystem::path& file, const ViewerSummary& summary) {
  const SourceStatus& source = summary.source;
  nlohmann::ordered_json json{
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
  json["registration"] = to_json(summary.registration);
  if (summary.live) json.update(to_json(*summary.live));
  write_file_whole(file, json.dump(2) + "\n");
}

}  // namespace

void run_viewer(const ViewerOptions& options, bool quiet) {
  if (!quiet) std::cout << key_table_text() << std::flush;
  const ViewerSummary summary = view_feed(options);
  if (summary.source.damaged > 0) {
    spdlog::warn("{} picture(s) could not be read and were left out", summary.source.damaged);
  }
  if (summary.live && !quiet) std::cout << to_text(*summary.live) << std::endl;
  if (options.replay.stats) std::cout << counters_text(summary.counters) << std::flush;
  if (options.json) write_json(*options.json, summary);
  throw_if_interrupted();
}

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  foreview view workcell\n"
    "  foreview view workcell --delay 800ms --jitter 100ms --loss 10% --view split\n"
    "  foreview view --scene cell.obj --topic /camera/image_raw/compressed\n"
    "  foreview view --scene workcell --topic /left/image_raw/compressed --topic /right/image_raw/compressed\n"
    "  foreview view --scene workcell --connect left --headless --duration 1min --out pictures --every 1s";

struct ViewCommand {
  ViewerOptions options;
  LiveOptionsCli live;
  LiveHeadlessOptions headless;
  double scale = 1;
  bool is_headless = false;
};

/// Options that mean nothing where there is no recording, and why.
constexpr std::array<std::pair<const char*, const char*>, 5> kOfRecordings{{
    {"--from", "a live stream begins now"},
    {"--to", "a live stream has no end; --headless takes --duration"},
    {"--history", "a live stream is not known before it came"},
    {"--speed", "nobody can slow a live stream down"},
    {"--loop", "a live stream does not come to an end"},
}};
constexpr std::array kOfLiveStreams{"--headless", "--every", "--duration", "--until-silent", "--size",
                                    "--pacing",   "--scale", "--pose",     "--world-frame"};

std::optional<LiveFeed::Options> live_options(const ViewCommand& given, const CLI::App& view) {
  const std::vector<CameraTopics> cameras = given.live.cameras();
  const ReplayOptions& replay = given.options.replay;
  if (cameras.empty()) {
    for (const char* option : kOfLiveStreams) {
      if (view.get_option(option)->count() == 0) continue;
      throw InputError(option, std::string(option) == "--headless"
                                   ? "is for live streams here (--topic, --connect); see foreview replay --headless"
                                   : "is for live streams; expected --topic or --connect with it");
    }
    if (replay.recording.empty()) throw InputError("view", "expected a recording, or --topic or --connect");
    return std::nullopt;
  }
  if (!replay.recording.empty()) {
    throw InputError(replay.recording.string(),
                     "a recording and a live stream cannot both be shown; for the scene, expected --scene");
  }
  for (const auto& [option, why] : kOfRecordings) {
    if (view.get_option(option)->count() > 0) throw InputError(option, why);
  }
  if (!replay.scene) {
    throw InputError("--scene", "expected the model of what the cameras see: a file, or a recording of the same place");
  }
  if (!(given.scale > 0 && given.scale <= 1e6)) throw InputError("--scale", "expected metres per unit, above 0");
  LiveFeed::Options options;
  options.scene = *replay.scene;
  options.scale = given.scale;
  options.network = given.live.network.options();
  options.cameras = cameras;
  options.source = given.live.source();
  std::string names;
  for (std::size_t i = 0; i < options.source.cameras.size(); ++i) {
    const std::string& name = options.source.cameras[i].name;
    if (name == replay.camera) options.source.operator_camera = i;
    names += (i == 0 ? "" : ", ") + name;
  }
  if (!replay.camera.empty() && options.source.cameras[options.source.operator_camera].name != replay.camera) {
    throw InputError("--camera", "'" + replay.camera + "' is none of the cameras heard: " + names);
  }
  return options;
}

void run(const ViewCommand& given, const CLI::App& view, bool quiet) {
  ViewerOptions options = given.options;
  const double speed = options.session.speed;
  if (!(speed >= 0.01 && speed <= 100)) throw InputError("--speed", "expected a factor from 0.01 to 100");
  if (options.rate && !(*options.rate >= 1 && *options.rate <= 500)) {
    throw InputError("--rate", "expected 1 to 500 frames a second");
  }
  options.live = live_options(given, view);
  // A link that is simulated comes on top of one that is real.
  const bool has_delay = !options.live || view.get_option("--delay")->count() > 0;
  options.link.delay = has_delay ? options.replay.delay : Duration{};
  if (options.live) options.live->source.link = options.link;
  if (!given.is_headless) return run_viewer(options, quiet);
  LiveHeadlessOptions headless = given.headless;
  headless.live = *options.live;
  headless.replay = options.replay;
  headless.choice = options.session.choice;
  headless.rate = options.rate;
  const CLI::Option* const quality = view.get_option("--quality");
  if (quality->count() > 0 && quality->results().back() != "auto") headless.quality = headless.choice.quality;
  headless.out = options.session.out;
  headless.json = options.json;
  view_live_headless(headless, quiet);
}

}  // namespace

void add_view_command(CLI::App& app) {
  CLI::App* view = app.add_subcommand(
      "view", "Look at a recording as if it came in live, or at live streams, in a window with all controls");
  const auto command = std::make_shared<ViewCommand>();
  ViewerOptions& options = command->options;
  add_replay_options(*view, options.replay, false);
  add_registration_option(*view, options.replay);
  add_pipeline_options(*view, options.replay);
  add_link_options(*view, options.link);
  view->add_option("--speed", options.session.speed, "Recorded seconds per second (default: 1)")->type_name("FACTOR");
  view->add_flag("--loop", options.session.loop, "Begin anew at the end");
  add_view_options(*view, options.session.choice);
  view->add_option("--rate", options.rate, "Frames a second (default: the monitor's up to 60; 33 where the CPU draws)")
      ->type_name("HZ");
  view->add_flag("!--no-panels", options.panels, "Begin with the panels hidden");
  view->add_option("--out", options.session.out, "Where pictures are saved (default: where you are)")->type_name("DIR");
  view->add_option("--json", options.json, "Write what was done to this file")->type_name("FILE");
  command->live.add_to(*view, true);
  view->add_option("--scale", command->scale, "Live: metres per unit of --scene's file (default: 1)")
      ->type_name("METRES");
  add_live_headless_options(*view, command->is_headless, command->headless);
  view->footer(kExamples + std::string("\n\n") + key_table_text());
  view->callback([command, &app, view] { run(*command, *view, app.count("--quiet") > 0); });
}

}  // namespace foreview
