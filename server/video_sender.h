#pragma once
#include <memory>
#include <optional>
#include <string>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"
#include "foreview/server/capture/v4l2_camera.h"
#include "foreview/server/dds/dds_node.h"

namespace foreview {

/// Publishes a camera's pictures as they come: /NAME/image_raw/compressed where they are compressed, else
/// /NAME/image_raw; /NAME/camera_info with the same stamps; and, where the camera stands still, its pose on tf_static
/// from "world" to NAME_optical_frame.
class VideoSender {
 public:
  struct Options {
    std::string name = "camera";
    CameraModel camera;  ///< of the size that the pictures have
    std::optional<Pose> world_from_camera;
    bool is_reliable = false;
  };
  /// The node must outlive the sender.
  VideoSender(DdsNode& node, Options options);
  void send(CapturedPicture picture);
  [[nodiscard]] std::string frame() const;

 private:
  DdsNode& node_;
  Options options_;
  QosProfile qos_;
  CameraInfoMessage info_;
  std::unique_ptr<DdsWriter<CameraInfoMessage>> info_writer_;
  std::unique_ptr<DdsWriter<TransformMessage>> static_writer_;
  std::unique_ptr<DdsWriter<CompressedImageMessage>> compressed_writer_;  ///< made with the first picture of its kind
  std::unique_ptr<DdsWriter<ImageMessage>> raw_writer_;
};

}  // namespace foreview
