#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/server/capture/v4l2_camera.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/recording_sender.h"
#include "foreview/server/video_sender.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_options_cli.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {
namespace {

struct SendCommand {
  std::filesystem::path recording, camera_file;
  NetworkOptionsCli network;
  RecordingSender::Options options;
  std::string device, format;
  double rate = 0;
  std::string name = "camera", pose, duration;
  bool waits = false;

  void run() const;
  void send_recording() const;
  void send_device() const;
};

/// "TX TY TZ QX QY QZ QW", as a line of groundtruth.txt without its stamp.
Pose parse_pose(const std::string& text) {
  std::istringstream numbers(text);
  Pose pose;
  glm::dvec3& t = pose.translation;
  glm::dquat& q = pose.rotation;
  std::string rest;
  const bool are_there = static_cast<bool>(numbers >> t.x >> t.y >> t.z >> q.x >> q.y >> q.z >> q.w);
  if (!are_there || numbers >> rest || !(std::abs(glm::length(q) - 1) < 1e-2) || !std::isfinite(glm::length(t))) {
    throw InputError("--pose", in_quotes(text) + " is no pose; expected TX TY TZ QX QY QZ QW with a unit quaternion");
  }
  pose.rotation = glm::normalize(q);
  return pose;
}

void SendCommand::run() const {
  if (recording.empty() == device.empty()) {
    throw InputError("send", "expected either a recording or --device");
  }
  if (device.empty()) {
    send_recording();
  } else {
    send_device();
  }
}

void SendCommand::send_recording() const {
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
  // The other side may learn of us a little later than we of it, and would miss what is sent until then.
  if (waits) std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const RecordingSender::Summary summary = sender.run([] { return !interrupted(); });
  spdlog::info("{} pictures sent, {} unreadable", summary.pictures, summary.unreadable);
  throw_if_interrupted();
  // What is reliable may have to be repeated.
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
}

void SendCommand::send_device() const {
  if (camera_file.empty())
    throw InputError("--device", "needs --camera FILE: the intrinsics that go with the pictures");
  VideoSender::Options video;
  video.name = name;
  video.camera = read_camera_yaml(camera_file);
  video.is_reliable = options.is_reliable;
  if (!pose.empty()) video.world_from_camera = parse_pose(pose);
  V4l2Camera::Options wanted;
  wanted.device = device;
  wanted.wish = {{}, video.camera.width, video.camera.height, rate};
  if (!format.empty()) wanted.wish.format = parse_capture_format(format, "--format");
  wanted.reopen = true;
  wanted.stamp_on_arrival = true;
  const Duration length = duration.empty() ? Duration{} : Duration::parse(duration, "--duration");
  V4l2Camera camera(wanted);
  DdsNode node(network.options());
  VideoSender sender(node, video);
  spdlog::info("{}: {}, {}", device, camera.name(), camera.mode().to_string());
  const Timestamp begun = steady_now();
  while (!interrupted() && (duration.empty() || steady_now() - begun < length)) {
    if (auto picture = camera.next(Duration{200'000'000})) sender.send(std::move(*picture));
  }
  const V4l2Camera::Statistics& s = camera.statistics();
  spdlog::info("{} pictures sent, {} overtaken, {} damaged, {} short, {} lost by the driver, unplugged {} times",
               s.delivered, s.overtaken, s.flagged + s.damaged, s.short_frames + s.wrong_size, s.lost, s.unplugged);
}

}  // namespace

void add_send_command(CLI::App& app) {
  auto* command = app.add_subcommand(
      "send", "Publish a recording, or a camera, as a ROS 2 robot would: pictures, camera_info, tf, joints");
  auto state = std::make_shared<SendCommand>();
  command->add_option("recording", state->recording, "A recording's directory, or the name of a built-in one")
      ->type_name("RECORDING");
  command->add_option("--speed", state->options.speed, "Recorded seconds per second")->capture_default_str();
  command->add_flag("--loop", state->options.loop, "Begin anew at the end, with stamps that go on");
  command->add_flag("--recorded-stamps", state->options.keeps_stamps, "Stamps as recorded, not those of now");
  command->add_flag("--reliable", state->options.is_reliable,
                    "Publish pictures reliably; default is ROS 2's best effort for sensor data");
  command->add_flag("--wait", state->waits, "Begin when somebody hears every camera");
  command->add_option("--device", state->device, "A V4L2 camera instead of a recording, as /dev/video0")
      ->type_name("DEVICE");
  command->add_option("--camera", state->camera_file, "Of the device: its intrinsics (camera.yaml), and size")
      ->type_name("FILE");
  command->add_option("--format", state->format, "Of the device: mjpeg, yuyv, uyvy or grey (default: the first it has)")
      ->type_name("NAME");
  command->add_option("--rate", state->rate, "Of the device: pictures per second")->type_name("HZ");
  command->add_option("--name", state->name, "Of the device: published as /NAME/image_raw")->capture_default_str();
  command
      ->add_option("--pose", state->pose, "Of the device, where it stands still: \"TX TY TZ QX QY QZ QW\" in the world")
      ->type_name("POSE");
  command->add_option("--duration", state->duration, "Of the device: end after this time; else with Ctrl-C")
      ->type_name("TIME");
  state->network.add_to(*command);
  command->footer("Example: foreview send workcell --wait");
  command->callback([state] { state->run(); });
}

}  // namespace foreview
