#include "foreview/server/live_receiver.h"

#include <utility>

namespace foreview {
namespace {

constexpr std::string_view kCompressed = "/compressed";

/// "/arm/image_raw/compressed" -> "/arm"
std::string camera_namespace(std::string topic) {
  if (topic.ends_with(kCompressed)) topic.resize(topic.size() - kCompressed.size());
  const std::size_t slash = topic.rfind('/');
  return slash == std::string::npos ? std::string() : topic.substr(0, slash);
}

}  // namespace

CameraTopics camera_topics(const std::string& image_topic) {
  const std::string base = camera_namespace(image_topic);
  return {image_topic, base.empty() ? "camera_info" : base + "/camera_info", ""};
}

std::string camera_name(const std::string& image_topic) {
  std::string name = camera_namespace(image_topic);
  name = name.substr(name.rfind('/') + 1);
  return name.empty() ? "camera" : name;
}

LiveReceiver::LiveReceiver(DdsNode& node, const std::vector<CameraTopics>& cameras, LiveSink& sink)
    : cameras_(cameras.size()) {
  // Pictures first: lost() counts theirs.
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string& topic = cameras[i].image;
    if (topic.ends_with(kCompressed)) {
      heard_.push_back({topic, node.subscribe<CompressedImageMessage>(
                                   topic, QosProfile::sensor_data,
                                   [&sink, i](CompressedImageMessage&& message, const Reception& reception) {
                                     sink.on_picture(i, std::move(message), reception);
                                   })});
    } else {
      heard_.push_back(
          {topic, node.subscribe<ImageMessage>(topic, QosProfile::sensor_data,
                                               [&sink, i](ImageMessage&& message, const Reception& reception) {
                                                 sink.on_picture(i, std::move(message), reception);
                                               })});
    }
  }
  bool needs_tf = false;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraTopics& topics = cameras[i];
    heard_.push_back({topics.camera_info,
                      node.subscribe<CameraInfoMessage>(topics.camera_info, QosProfile::sensor_data,
                                                        [&sink, i](CameraInfoMessage&& message, const Reception&) {
                                                          sink.on_camera_info(i, message);
                                                        })});
    needs_tf = needs_tf || topics.pose.empty();
    if (topics.pose.empty()) continue;
    heard_.push_back({topics.pose, node.subscribe<PoseMessage>(topics.pose, QosProfile::sensor_data,
                                                               [&sink, i](PoseMessage&& message, const Reception&) {
                                                                 sink.on_pose(i, message);
                                                               })});
  }
  heard_.push_back({"/tf",
                    node.subscribe<TransformMessage>(
                        "/tf", QosProfile::transforms,
                        [&sink](TransformMessage&& message, const Reception&) { sink.on_transforms(message, false); }),
                    needs_tf});
  heard_.push_back({"/tf_static",
                    node.subscribe<TransformMessage>(
                        "/tf_static", QosProfile::static_transforms,
                        [&sink](TransformMessage&& message, const Reception&) { sink.on_transforms(message, true); }),
                    false});
  heard_.push_back({"/joint_states",
                    node.subscribe<JointStateMessage>(
                        "/joint_states", QosProfile::sensor_data,
                        [&sink](JointStateMessage&& message, const Reception&) { sink.on_joints(message); }),
                    false});
}

std::string LiveReceiver::missing() const {
  std::string topics;
  for (const Heard& heard : heard_) {
    if (heard.is_needed && heard.reader->publishers() == 0) topics += (topics.empty() ? "" : ", ") + heard.topic;
  }
  return topics.empty() ? "" : "nobody publishes " + topics;
}

std::size_t LiveReceiver::lost() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < cameras_; ++i) count += heard_[i].reader->lost();
  return count;
}

}  // namespace foreview
