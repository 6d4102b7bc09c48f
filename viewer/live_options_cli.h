#pragma once
#include <memory>
#include <string>
#include <vector>

#include "foreview/scene/timestamp.h"
#include "foreview/server/dds/dds_node.h"
#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"

namespace CLI {
class App;
}

namespace foreview {

/// Options of the commands that speak over the network.
struct NetworkOptionsCli {
  std::string domain;  ///< empty: ROS_DOMAIN_ID
  std::string network = "loopback";
  void add_to(CLI::App& command);
  [[nodiscard]] DdsOptions options() const;
};

/// Options of the commands that hear live streams.
struct LiveOptionsCli {
  NetworkOptionsCli network;
  std::vector<std::string> topics, poses;
  std::vector<std::string> servers;  ///< cameras of `foreview serve --republish`, by name
  std::string world_frame = "world";
  std::string state_wait = "250ms";
  bool clocks_are_synchronised = false;
  std::string least_delay = "0ms";
  /// `may_connect`: --connect is offered, too, and neither it nor --topic is required.
  void add_to(CLI::App& command, bool may_connect = false);
  /// Those of --topic, then those of --connect.
  [[nodiscard]] std::vector<CameraTopics> cameras() const;
  /// Throws InputError naming the option.
  [[nodiscard]] LiveSource::Options source() const;
};

}  // namespace foreview
