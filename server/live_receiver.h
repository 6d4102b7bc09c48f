#pragma once
#include <memory>
#include <string>
#include <vector>

#include "foreview/server/dds/dds_node.h"
#include "foreview/server/live_sink.h"

namespace foreview {

/// Where a camera's stream is heard.
struct CameraTopics {
  std::string image;        ///< sensor_msgs/CompressedImage where it ends in "/compressed", else sensor_msgs/Image
  std::string camera_info;  ///< sensor_msgs/CameraInfo
  std::string pose;         ///< geometry_msgs/PoseStamped of the optical frame; empty: the pose comes from tf
};
/// ROS 2's habits: "/arm/image_raw/compressed" goes with "/arm/camera_info". The camera is called "arm".
[[nodiscard]] CameraTopics camera_topics(const std::string& image_topic);
[[nodiscard]] std::string camera_name(const std::string& image_topic);

/// Hears the streams of some cameras, tf and joint states, and hands all on to a sink, until it is destroyed.
class LiveReceiver {
 public:
  /// Node and sink must outlive the receiver. Throws InputError on names that are no topics'.
  LiveReceiver(DdsNode& node, const std::vector<CameraTopics>& cameras, LiveSink& sink);
  /// One line on what is not heard (no publisher of a topic); empty: all is.
  [[nodiscard]] std::string missing() const;
  /// Pictures known to have been lost on the network: of all cameras, of one.
  [[nodiscard]] std::size_t lost() const;
  [[nodiscard]] std::size_t lost(std::size_t camera) const { return heard_[camera].reader->lost(); }

 private:
  struct Heard {
    std::string topic;
    std::unique_ptr<DdsReader> reader;
    bool is_needed = true;
  };
  std::vector<Heard> heard_;
  std::size_t cameras_;
};

}  // namespace foreview
