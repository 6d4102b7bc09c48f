#include "foreview/viewer/live_options_cli.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/server/republisher.h"

namespace foreview {

void NetworkOptionsCli::add_to(CLI::App& command) {
  command.add_option("--domain", domain, "DDS domain, 0 to 232 (default: ROS_DOMAIN_ID, else 0)")->type_name("N");
  command
      .add_option("--network", network,
                  "loopback (this machine only), any (as Cyclone DDS or CYCLONEDDS_URI chooses), or an interface")
      ->type_name("NAME")
      ->capture_default_str();
}

DdsOptions NetworkOptionsCli::options() const {
  DdsOptions options;
  options.network = network;
  if (domain.empty()) {
    options.domain = default_dds_domain();
    return options;
  }
  const auto [end, error] = std::from_chars(domain.data(), domain.data() + domain.size(), options.domain);
  if (error != std::errc() || end != domain.data() + domain.size() || options.domain < 0 || options.domain > 232) {
    throw InputError("--domain", in_quotes(domain) + " is no domain; expected 0 to 232");
  }
  return options;
}

void LiveOptionsCli::add_to(CLI::App& command, bool may_connect) {
  command
      .add_option("--topic", topics,
                  "A camera's pictures: sensor_msgs/CompressedImage where it ends in /compressed, else "
                  "sensor_msgs/Image; may be repeated. Its camera_info is heard beside it")
      ->type_name("TOPIC")
      ->required(!may_connect);
  if (may_connect) {
    command
        .add_option("--connect", servers,
                    "A camera of a foreview serve --republish, which decodes its pictures elsewhere, by its name; may "
                    "be repeated")
        ->type_name("NAME");
  }
  command
      .add_option("--pose", poses,
                  "A camera's pose as geometry_msgs/PoseStamped, in the order of --topic (default: from tf, by the "
                  "pictures' frame_id)")
      ->type_name("TOPIC");
  command.add_option("--world-frame", world_frame, "The frame of tf in which the model lies")
      ->type_name("FRAME")
      ->capture_default_str();
  command.add_option("--state-wait", state_wait, "A picture waits this long for pose and model state, then is dropped")
      ->type_name("TIME")
      ->capture_default_str();
  command.add_flag("--clocks-synchronised", clocks_are_synchronised,
                   "The robot's clock agrees with this machine's (PTP, NTP): take stamps as they are");
  command
      .add_option("--least-delay", least_delay,
                  "What the fastest picture takes from capture to arrival; without synchronised clocks nothing can "
                  "tell, and latencies are those beyond it")
      ->type_name("TIME")
      ->capture_default_str();
  network.add_to(command);
}

std::vector<CameraTopics> LiveOptionsCli::cameras() const {
  if (poses.size() > topics.size())
    throw InputError("--pose", "is given more often than --topic; expected one for each");
  std::vector<CameraTopics> cameras;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    cameras.push_back(camera_topics(topics[i]));
    if (i < poses.size()) cameras.back().pose = poses[i];
  }
  for (const std::string& name : servers) cameras.push_back(Republisher::topics(name));
  return cameras;
}

LiveSource::Options LiveOptionsCli::source() const {
  LiveSource::Options options;
  for (const CameraTopics& topics_of_camera : cameras()) {
    options.cameras.push_back({camera_name(topics_of_camera.image), "", !topics_of_camera.pose.empty()});
  }
  options.world_frame = world_frame;
  options.state_wait = Duration::parse(state_wait, "--state-wait");
  if (clocks_are_synchronised) options.clock.mode = ClockMode::synchronised;
  options.clock.least_delay = Duration::parse(least_delay, "--least-delay");
  return options;
}

}  // namespace foreview
