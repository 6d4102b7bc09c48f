#include "foreview/server/video_sender.h"

#include <utility>

#include "foreview/server/camera_info.h"

namespace foreview {

VideoSender::VideoSender(DdsNode& node, Options options)
    : node_(node),
      options_(std::move(options)),
      qos_(options_.is_reliable ? QosProfile::reliable : QosProfile::sensor_data),
      info_(info_from_camera(options_.camera)),
      info_writer_(node.advertise<CameraInfoMessage>("/" + options_.name + "/camera_info", qos_)),
      static_writer_(node.advertise<TransformMessage>("/tf_static", QosProfile::static_transforms)) {
  if (options_.world_from_camera) static_writer_->write({{{{{}, "world"}, frame(), *options_.world_from_camera}}});
}

std::string VideoSender::frame() const {
  return options_.name + "_optical_frame";
}

void VideoSender::send(CapturedPicture picture) {
  const std::string base = "/" + options_.name + "/image_raw";
  const MessageHeader header{picture.stamp, frame()};
  info_.header = header;
  info_writer_->write(info_);
  if (picture.encoding == "jpeg") {
    if (!compressed_writer_) compressed_writer_ = node_.advertise<CompressedImageMessage>(base + "/compressed", qos_);
    compressed_writer_->write({header, picture.encoding, std::move(picture.bytes)});
    return;
  }
  if (!raw_writer_) raw_writer_ = node_.advertise<ImageMessage>(base, qos_);
  const auto height = static_cast<std::uint32_t>(picture.height), width = static_cast<std::uint32_t>(picture.width);
  const auto step = static_cast<std::uint32_t>(picture.bytes.size() / height);
  raw_writer_->write({header, height, width, picture.encoding, false, step, std::move(picture.bytes)});
}

}  // namespace foreview
