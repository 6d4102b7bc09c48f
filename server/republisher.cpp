#include "foreview/server/republisher.h"

#include <utility>

#include "foreview/server/camera_info.h"

namespace foreview {

Republisher::Republisher(DdsNode& node, const std::vector<std::string>& camera_names, std::string world_frame)
    : world_frame_(std::move(world_frame)) {
  for (const std::string& name : camera_names) {
    const CameraTopics at = topics(name);
    cameras_.push_back({node.advertise<ImageMessage>(at.image, QosProfile::sensor_data),
                        node.advertise<CameraInfoMessage>(at.camera_info, QosProfile::sensor_data),
                        node.advertise<PoseMessage>(at.pose, QosProfile::sensor_data)});
  }
}

CameraTopics Republisher::topics(const std::string& camera_name) {
  const std::string base = "/foreview/" + camera_name;
  return {base + "/image_raw", base + "/camera_info", base + "/pose"};
}

void Republisher::send(const IncomingFrame& frame) {
  const Camera& camera = cameras_.at(frame.camera);
  const cv::Mat& picture = frame.frame.picture;
  const MessageHeader header{frame.frame.state.stamp, world_frame_};
  camera.poses->write({header, frame.frame.state.world_from_camera});
  CameraInfoMessage info = info_from_camera(frame.frame.camera);
  info.header = header;
  camera.info->write(info);
  ImageMessage image{header,
                     static_cast<std::uint32_t>(picture.rows),
                     static_cast<std::uint32_t>(picture.cols),
                     "bgr8",
                     false,
                     static_cast<std::uint32_t>(picture.cols * 3),
                     {}};
  for (int y = 0; y < picture.rows; ++y)
    image.data.insert(image.data.end(), picture.ptr(y), picture.ptr(y) + picture.cols * 3);
  camera.pictures->write(image);
}

}  // namespace foreview
