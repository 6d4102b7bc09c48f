#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "foreview/server/frame_source.h"
#include "foreview/server/recording_sender.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_options_cli.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {
namespace {

struct SendCommand {
  std::filesystem::path recording;
  NetworkOptionsCli network;
  RecordingSender::Options options;
  bool waits = false;

  void run() const;
};

void SendCommand::run() const {
  const Recording played = open_recording(recording);
  DdsNode node(network.options());
  RecordingSender sender(played, node, options);
  for (const Recording::Camera& camera : played.cameras()) {
    spdlog::info("publishing {}", RecordingSender::image_topic(camera.name));
  }
  if (waits) spdlog::info("waiting for a subscriber");
  while (waits && !sender.is_heard()) {
    throw_if_interrupted();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const RecordingSender::Summary summary = sender.run([] { return !interrupted(); });
  spdlog::info("{} pictures sent, {} unreadable", summary.pictures, summary.unreadable);
  throw_if_interrupted();
  // What is reliable may have to be repeated.
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
}

}  // namespace

void add_send_command(CLI::App& app) {
  auto* command =
      app.add_subcommand("send", "Publish a recording as a ROS 2 robot would: pictures, camera_info, tf, joints");
  auto state = std::make_shared<SendCommand>();
  command->add_option("recording", state->recording, "A recording's directory, or the name of a built-in one")
      ->type_name("RECORDING")
      ->required();
  command->add_option("--speed", state->options.speed, "Recorded seconds per second")->capture_default_str();
  command->add_flag("--loop", state->options.loop, "Begin anew at the end, with stamps that go on");
  command->add_flag("--recorded-stamps", state->options.keeps_stamps, "Stamps as recorded, not those of now");
  command->add_flag("--reliable", state->options.is_reliable,
                    "Publish pictures reliably; default is ROS 2's best effort for sensor data");
  command->add_flag("--wait", state->waits, "Begin when somebody hears every camera");
  state->network.add_to(*command);
  command->footer("Example: foreview send workcell --wait");
  command->callback([state] { state->run(); });
}

}  // namespace foreview
