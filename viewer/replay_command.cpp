#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/link_options_cli.h"
#include "foreview/viewer/picture_output.h"
#include "foreview/viewer/progress.h"
#include "foreview/viewer/registration_report.h"
#include "foreview/viewer/replay_options_cli.h"
#include "foreview/viewer/replay_pacing.h"
#include "foreview/viewer/replay_session.h"
#include "foreview/viewer/replayer.h"
#include "foreview/viewer/view_options_cli.h"
#include "foreview/viewer/viewer_session.h"

namespace foreview {
namespace {

struct ReplayCommand {
  ReplayPacingOptions pacing;
  ReplayOptions replay;
  LinkOptions link;
  ReplaySessionOptions session;
  bool headless = false;
  std::optional<std::filesystem::path> json;
};

constexpr const char* kExamples =
    "Examples:\n"
    "  foreview replay workcell --delay 500ms\n"
    "  foreview replay my-recording --headless --out pictures --view both --every 10\n"
    "  foreview replay workcell --headless --out pictures --at 2.5 --camera-mode overview --cone --never-seen\n"
    "  foreview replay workcell --headless --rate 50 --duration 20s --reference --pacing pacing.json";

void check(const ReplayCommand& command) {
  const double speed = command.session.speed;
  if (!(speed >= 0.01 && speed <= 100)) throw InputError("--speed", "expected a factor from 0.01 to 100");
  if (command.session.every < 1) throw InputError("--every", "expected 1 or more");
  if (command.pacing.rate) {
    if (!command.headless) throw InputError("--rate", "expected --headless with it; a window has a rate of its own");
    if (command.replay.history) throw InputError("--history", "is not for --rate: pictures come as they arrive");
    if (!command.session.out.empty()) throw InputError("--out", "is not for --rate, which writes no pictures");
  } else if (!command.session.at.empty() && !command.headless) {
    throw InputError("--at", "expected --headless with it; a window begins at --from");
  } else if (command.headless && command.session.out.empty()) {
    throw InputError("--headless", "expected --out DIR with it, for the pictures, or --rate HZ");
  }
  if (command.headless && !command.pacing.rate && command.link != LinkOptions()) {
    throw InputError("--jitter, --loss, --bandwidth, --link-seed",
                     "expected a window or --rate with them; written pictures show a constant delay");
  }
  if (command.pacing.back_to_back && command.link != LinkOptions()) {
    throw InputError("--back-to-back", "is not for --jitter, --loss or --bandwidth: its pictures come over no link");
  }
}

void write_json(const std::filesystem::path& file, Replayer& replayer, const ReplayCommand& command,
                const ReplaySummary& summary) {
  const RecordingDamage& damage = replayer.recording().damage();
  const ExtractionStatistics& statistics = replayer.statistics();
  const nlohmann::ordered_json json{
      {"format", "foreview-replay"},
      {"version", 1},
      {"recording", replayer.recording().name()},
      {"camera", replayer.operator_camera().name},
      {"delay_seconds", command.replay.delay.seconds()},
      {"from_seconds", (replayer.first() - replayer.recording().first_stamp(replayer.camera())).seconds()},
      {"to_seconds", (replayer.last() - replayer.recording().first_stamp(replayer.camera())).seconds()},
      {"view", to_string(command.session.choice.mode)},
      {"pictures_written", summary.pictures_written},
      {"instants_without_state", summary.instants_without_state},
      {"pictures_extracted", replayer.pictures_extracted()},
      {"pictures_unreadable", damage.pictures_unreadable},
      {"items_damaged", damage.total()},
      {"polygons", replayer.model().polygons().size()},
      {"polygons_visible", statistics.polygons_visible},
      {"registration", to_json(replayer.registration())},
  };
  write_file_whole(file, json.dump(2) + "\n");
}

void view(const ReplayCommand& command, bool quiet) {
  ViewerOptions options;
  options.replay = command.replay;
  options.session = command.session;
  options.link = command.link;
  options.link.delay = command.replay.delay;
  options.json = command.json;
  run_viewer(options, quiet);
}

void run(const ReplayCommand& given, bool quiet) {
  ReplayCommand command = given;
  command.session.delay = command.replay.delay;
  command.session.near_plane = command.replay.extraction.near_plane;
  check(command);
  if (command.pacing.rate) {
    replay_pacing(command.replay, command.link, command.pacing, quiet);
    return;
  }
  if (!command.headless) return view(command, quiet);
  const GlDebug debug = gl_debug_from_environment();
  const OffscreenContext context(OffscreenContext::Options{.debug = debug != GlDebug::off});
  if (debug != GlDebug::off) install_debug_callback(debug == GlDebug::fatal);
  spdlog::debug("graphics: {}", context.renderer());
  Replayer replayer(command.replay);
  const ReplaySummary summary = replay_headless(replayer, command.session);
  if (!quiet) {
    std::cout << summary.pictures_written << " pictures in " << command.session.out.string() << "/"
              << to_string(command.session.choice.mode) << "; registration: " << to_text(replayer.registration())
              << "\n";
  }
  if (replayer.pictures_damaged() > 0) {
    spdlog::warn("{} picture(s) could not be read and were left out", replayer.pictures_damaged());
  }
  if (command.replay.stats) std::cout << counters_text(replayer.counters()) << std::flush;
  replayer.save_textures_if_asked();
  if (command.json) write_json(*command.json, replayer, command, summary);
  throw_if_interrupted();
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* replay = app.add_subcommand("replay", "Show the predicted view of a recording, in a window or as pictures");
  const auto command = std::make_shared<ReplayCommand>();
  add_replay_options(*replay, command->replay);
  add_registration_option(*replay, command->replay);
  add_pipeline_options(*replay, command->replay);
  add_link_options(*replay, command->link);
  ReplaySessionOptions& session = command->session;
  replay->add_option("--speed", session.speed, "Recorded seconds per second (default: 1)")->type_name("FACTOR");
  replay->add_flag("--loop", session.loop, "Begin anew at the end");
  add_view_options(*replay, session.choice);
  replay->add_flag("--headless", command->headless, "No window: write DIR/VIEW/PICTURE.png for every picture's time");
  replay->add_option("--out", session.out, "Where pictures go (default for S: where you are)")->type_name("DIR");
  replay->add_option("--every", session.every, "Headless: only every Nth picture's time (default: 1)")->type_name("N");
  replay
      ->add_option("--at", session.at,
                   "Headless: only one frame, at exactly this time: seconds from the start, or #200")
      ->type_name("POSITION");
  replay->add_option("--json", command->json, "Write what was done to this file")->type_name("FILE");
  add_pacing_options(*replay, command->pacing);
  replay->footer(kExamples);
  replay->callback([command, &app, replay] {
    const CLI::Option* const quality = replay->get_option("--quality");
    if (quality->count() > 0 && quality->results().back() != "auto") {
      command->pacing.quality = command->session.choice.quality;
    }
    run(*command, app.count("--quiet") > 0);
  });
}

}  // namespace foreview
