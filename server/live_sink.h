#pragma once
#include <cstddef>

#include "foreview/server/dds/dds_node.h"
#include "foreview/server/encoded_picture.h"

namespace foreview {

/// What takes in the messages of live streams. Called from threads of the network, as messages come; no member may
/// wait for anything long.
class LiveSink {
 public:
  virtual ~LiveSink() = default;
  virtual void on_picture(std::size_t camera, EncodedPicture picture, const Reception& reception) = 0;
  virtual void on_camera_info(std::size_t camera, const CameraInfoMessage& info) = 0;
  virtual void on_transforms(const TransformMessage& message, bool is_static) = 0;
  /// The pose of the camera's optical frame in the frame of the message's header (the world's where it is empty).
  virtual void on_pose(std::size_t camera, const PoseMessage& pose) = 0;
  virtual void on_joints(const JointStateMessage& joints) = 0;
};

}  // namespace foreview
