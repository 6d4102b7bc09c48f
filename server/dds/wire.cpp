#include "foreview/server/dds/wire.h"

#include <algorithm>
#include <limits>

namespace foreview::wire {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::string text_of(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}

char* lent(const std::string& text) {
  return const_cast<char*>(text.c_str());  // the generated types know no const; writing reads only
}

Timestamp stamp_of(const builtin_interfaces_msg_dds__Time_& time) {
  return {std::int64_t{time.sec} * kSecond + std::int64_t{time.nanosec}};
}

builtin_interfaces_msg_dds__Time_ time_of(Timestamp stamp) {
  std::int64_t seconds = stamp.nanoseconds / kSecond, rest = stamp.nanoseconds % kSecond;
  if (rest < 0) {
    rest += kSecond;
    --seconds;
  }
  constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  return {static_cast<std::int32_t>(std::clamp(seconds, kLeast, kMost)), static_cast<std::uint32_t>(rest)};
}

MessageHeader header_of(const std_msgs_msg_dds__Header_& header) {
  return {stamp_of(header.stamp), text_of(header.frame_id)};
}

std_msgs_msg_dds__Header_ lent(const MessageHeader& header) {
  return {time_of(header.stamp), lent(header.frame)};
}

template <class T, class Sequence>
std::vector<T> vector_of(const Sequence& sequence) {
  if (sequence._buffer == nullptr) return {};
  return std::vector<T>(sequence._buffer, sequence._buffer + sequence._length);
}

template <class Sequence, class T>
Sequence lent(const std::vector<T>& values) {
  Sequence sequence{};
  sequence._maximum = sequence._length = static_cast<std::uint32_t>(values.size());
  sequence._buffer = const_cast<T*>(values.data());
  sequence._release = false;
  return sequence;
}

Pose pose_of(const auto& position, const geometry_msgs_msg_dds__Quaternion_& q) {
  return {{q.w, q.x, q.y, q.z}, {position.x, position.y, position.z}};
}

geometry_msgs_msg_dds__Quaternion_ quaternion_of(const Pose& pose) {
  return {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w};
}

}  // namespace

CompressedImageMessage Type<CompressedImageMessage>::read(const Sample& sample) {
  return {header_of(sample.header), text_of(sample.format), vector_of<std::uint8_t>(sample.data)};
}
auto Type<CompressedImageMessage>::lend(const CompressedImageMessage& message, Lending& /*unused*/) -> Sample {
  return {lent(message.header), lent(message.format), lent<dds_sequence_octet>(message.data)};
}

ImageMessage Type<ImageMessage>::read(const Sample& sample) {
  return {header_of(sample.header),
          sample.height,
          sample.width,
          text_of(sample.encoding),
          sample.is_bigendian != 0,
          sample.step,
          vector_of<std::uint8_t>(sample.data)};
}
auto Type<ImageMessage>::lend(const ImageMessage& message, Lending& /*unused*/) -> Sample {
  return {lent(message.header),
          message.height,
          message.width,
          lent(message.encoding),
          static_cast<std::uint8_t>(message.is_big_endian ? 1 : 0),
          message.step,
          lent<dds_sequence_octet>(message.data)};
}

CameraInfoMessage Type<CameraInfoMessage>::read(const Sample& sample) {
  CameraInfoMessage message;
  message.header = header_of(sample.header);
  message.height = sample.height;
  message.width = sample.width;
  message.distortion_model = text_of(sample.distortion_model);
  message.d = vector_of<double>(sample.d);
  std::copy(std::begin(sample.k), std::end(sample.k), message.k.begin());
  message.binning_x = sample.binning_x;
  message.binning_y = sample.binning_y;
  message.roi = {sample.roi.x_offset, sample.roi.y_offset, sample.roi.height, sample.roi.width};
  return message;
}
auto Type<CameraInfoMessage>::lend(const CameraInfoMessage& message, Lending& /*unused*/) -> Sample {
  Sample sample{};
  sample.header = lent(message.header);
  sample.height = message.height;
  sample.width = message.width;
  sample.distortion_model = lent(message.distortion_model);
  sample.d = lent<dds_sequence_double>(message.d);
  std::copy(message.k.begin(), message.k.end(), std::begin(sample.k));
  // Unrectified picture of one camera: r is the identity, p is k with a fourth column of zeros.
  for (const int i : {0, 4, 8}) sample.r[i] = 1;
  for (std::size_t row = 0; row < 3; ++row) {
    std::copy_n(message.k.begin() + static_cast<std::ptrdiff_t>(3 * row), 3, sample.p + 4 * row);
  }
  sample.binning_x = message.binning_x;
  sample.binning_y = message.binning_y;
  sample.roi = {message.roi.x_offset, message.roi.y_offset, message.roi.height, message.roi.width, false};
  return sample;
}

JointStateMessage Type<JointStateMessage>::read(const Sample& sample) {
  JointStateMessage message;
  message.header = header_of(sample.header);
  for (std::uint32_t i = 0; i < sample.name._length; ++i) message.name.push_back(text_of(sample.name._buffer[i]));
  message.position = vector_of<double>(sample.position);
  return message;
}
auto Type<JointStateMessage>::lend(const JointStateMessage& message, Lending& lending) -> Sample {
  Sample sample{};
  sample.header = lent(message.header);
  for (const std::string& name : message.name) lending.strings.push_back(lent(name));
  sample.name = lent<dds_sequence_string>(lending.strings);
  sample.position = lent<dds_sequence_double>(message.position);
  return sample;
}

TransformMessage Type<TransformMessage>::read(const Sample& sample) {
  TransformMessage message;
  for (std::uint32_t i = 0; i < sample.transforms._length; ++i) {
    const auto& transform = sample.transforms._buffer[i];
    message.transforms.push_back({header_of(transform.header), text_of(transform.child_frame_id),
                                  pose_of(transform.transform.translation, transform.transform.rotation)});
  }
  return message;
}
auto Type<TransformMessage>::lend(const TransformMessage& message, Lending& lending) -> Sample {
  for (const TransformMessage::Transform& transform : message.transforms) {
    const glm::dvec3& t = transform.parent_from_child.translation;
    lending.transforms.push_back({lent(transform.header),
                                  lent(transform.child_frame),
                                  {{t.x, t.y, t.z}, quaternion_of(transform.parent_from_child)}});
  }
  return {lent<dds_sequence_geometry_msgs_msg_dds__TransformStamped_>(lending.transforms)};
}

PoseMessage Type<PoseMessage>::read(const Sample& sample) {
  return {header_of(sample.header), pose_of(sample.pose.position, sample.pose.orientation)};
}
auto Type<PoseMessage>::lend(const PoseMessage& message, Lending& /*unused*/) -> Sample {
  const glm::dvec3& t = message.pose.translation;
  return {lent(message.header), {{t.x, t.y, t.z}, quaternion_of(message.pose)}};
}

TextMessage Type<TextMessage>::read(const Sample& sample) {
  return {text_of(sample.data)};
}
auto Type<TextMessage>::lend(const TextMessage& message, Lending& /*unused*/) -> Sample {
  return {lent(message.data)};
}

}  // namespace foreview::wire
