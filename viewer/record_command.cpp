#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <thread>

#include "foreview/scene/errors.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/stream_recorder.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_options_cli.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

struct RecordCommand {
  fs::path out, scene;
  std::string duration;
  LiveOptionsCli live;

  void run() const;
};

void RecordCommand::run() const {
  StreamRecorder::Options options;
  options.directory = out;
  options.name = fs::absolute(out).lexically_normal().filename().string();
  options.world_frame = live.world_frame;
  for (const CameraTopics& topics : live.cameras()) {
    options.cameras.push_back({camera_name(topics.image), "", !topics.pose.empty()});
  }
  const Duration length = duration.empty() ? Duration{} : Duration::parse(duration, "--duration");
  std::error_code error;
  if (fs::exists(out / "recording.yaml", error)) throw InputError(out.string(), "holds a recording already");
  if (!scene.empty()) {
    for (const std::string& part : read_mesh(scene).part_names) options.parts.push_back(part);
    options.scene_file = "scene" + scene.extension().string();
    fs::create_directories(out, error);
    if (!fs::copy_file(scene, out / options.scene_file, fs::copy_options::overwrite_existing, error)) {
      throw InputError((out / options.scene_file).string(), "cannot be written: " + error.message());
    }
  }
  DdsNode node(live.network.options());
  StreamRecorder recorder(options);
  const LiveReceiver receiver(node, live.cameras(), recorder);
  const Timestamp begun = steady_now();
  Timestamp told = begun;
  while (!interrupted() && (duration.empty() || steady_now() - begun < length) && recorder.status().error.empty()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (steady_now() - told < Duration{2'000'000'000}) continue;
    told = steady_now();
    const StreamRecorder::Status status = recorder.status();
    const std::string missing = receiver.missing();
    spdlog::info("{} pictures recorded, {} without pose, {} damaged, {} late, {} overflowed{}", status.written,
                 status.stateless, status.damaged, status.late, status.overflowed,
                 !missing.empty()             ? "; " + missing
                 : status.waiting_for.empty() ? ""
                                              : "; waiting for " + status.waiting_for);
  }
  recorder.finish();
  const StreamRecorder::Status status = recorder.status();
  if (!status.error.empty()) throw InputError("recording ended", status.error);
  spdlog::info("{} of {} pictures recorded", status.written, status.pictures_in);
  std::printf("%s\n", out.string().c_str());
}

}  // namespace

void add_record_command(CLI::App& app) {
  auto* command = app.add_subcommand("record", "Write live streams into a recording while they run");
  auto state = std::make_shared<RecordCommand>();
  command->add_option("out", state->out, "Directory of the new recording")->type_name("DIR")->required();
  command->add_option("--scene", state->scene, "The scene's model: copied into the recording; its parts are recorded")
      ->type_name("FILE")
      ->check(CLI::ExistingFile);
  command->add_option("--duration", state->duration, "End by itself after this time; else with Ctrl-C")
      ->type_name("TIME");
  state->live.add_to(*command);
  command->footer("Example: foreview record trial-7 --topic /camera/image_raw/compressed --scene cell.obj");
  command->callback([state] { state->run(); });
}

}  // namespace foreview
