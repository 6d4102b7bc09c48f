#pragma once
#include <memory>
#include <string>
#include <vector>

#include "foreview/server/dds/dds_node.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/live_receiver.h"

namespace foreview {

/// Hands pictures on to a display elsewhere, decoded and with their pose: of camera NAME, /foreview/NAME/image_raw
/// (bgr8), /foreview/NAME/camera_info and /foreview/NAME/pose (the optical frame's in the world), all with the
/// picture's stamp. What has not been sent when a newer one comes is never sent: the server's mailbox sees to that.
class Republisher {
 public:
  Republisher(DdsNode& node, const std::vector<std::string>& camera_names, std::string world_frame);
  void send(const IncomingFrame& frame);
  /// Where the display elsewhere hears a camera.
  [[nodiscard]] static CameraTopics topics(const std::string& camera_name);

 private:
  struct Camera {
    std::unique_ptr<DdsWriter<ImageMessage>> pictures;
    std::unique_ptr<DdsWriter<CameraInfoMessage>> info;
    std::unique_ptr<DdsWriter<PoseMessage>> poses;
  };
  std::vector<Camera> cameras_;
  std::string world_frame_;
};

}  // namespace foreview
