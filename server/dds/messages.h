#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "foreview/scene/pose.h"
#include "foreview/scene/timestamp.h"

namespace foreview {

// ROS 2's messages, as far as foreview speaks them, in our own types. What a network says is in them unchecked: sizes
// that do not fit the data, numbers that are not finite, quaternions off unit length. Fields without meaning for us
// are not kept, and sent as ROS 2's defaults.

struct MessageHeader {
  Timestamp stamp;
  std::string frame;  ///< frame_id
};

struct CompressedImageMessage {  ///< sensor_msgs/CompressedImage
  MessageHeader header;
  std::string format;  ///< "jpeg", "png", "rgb8; jpeg compressed bgr8" ...
  std::vector<std::uint8_t> data;
};

struct ImageMessage {  ///< sensor_msgs/Image
  MessageHeader header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;  ///< "mono8", "rgb8" ...
  bool is_big_endian = false;
  std::uint32_t step = 0;  ///< bytes per row
  std::vector<std::uint8_t> data;
};

struct CameraInfoMessage {  ///< sensor_msgs/CameraInfo
  MessageHeader header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::uint32_t binning_x = 0, binning_y = 0;
  struct Region {
    std::uint32_t x_offset = 0, y_offset = 0, height = 0, width = 0;
  } roi;
};

struct JointStateMessage {  ///< sensor_msgs/JointState
  MessageHeader header;
  std::vector<std::string> name;
  std::vector<double> position;
};

struct TransformMessage {  ///< tf2_msgs/TFMessage
  struct Transform {
    MessageHeader header;  ///< frame: the parent's
    std::string child_frame;
    Pose parent_from_child;
  };
  std::vector<Transform> transforms;
};

struct PoseMessage {  ///< geometry_msgs/PoseStamped
  MessageHeader header;
  Pose pose;  ///< header.frame from whatever the topic is about
};

struct TextMessage {  ///< std_msgs/String
  std::string data;
};

}  // namespace foreview
