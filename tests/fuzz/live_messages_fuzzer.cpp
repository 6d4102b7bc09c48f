#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/dds/wire.h"
#include "foreview/server/encoded_picture.h"
#include "foreview/server/tf_buffer.h"
#include "require.h"

// A message from the network, from its encapsulation header on: Cyclone DDS decodes it, and what becomes of it is a
// usable camera, pose or picture, or refused.
namespace {

using namespace foreview;

dds_entity_t participant() {
  static const dds_entity_t handle = [] {
    const auto domain = static_cast<dds_domainid_t>(getpid() % 200);
    dds_create_domain(domain,
                      "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
                      "<AllowMulticast>false</AllowMulticast></General></Domain></CycloneDDS>");
    return dds_create_participant(domain, nullptr, nullptr);
  }();
  return handle;
}

/// How Cyclone decodes a type, from a sample that went to and fro: it has no other way to ask for it.
const ddsi_sertype* type_of(const dds_topic_descriptor_t& descriptor) {
  const dds_entity_t topic = dds_create_topic(participant(), &descriptor, "t", nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant(), topic, nullptr, nullptr);
  const dds_entity_t writer = dds_create_writer(participant(), topic, nullptr, nullptr);
  void* sample = dds_alloc(descriptor.m_size);
  FUZZ_REQUIRE(dds_write(writer, sample) == DDS_RETCODE_OK);
  dds_sample_free(sample, &descriptor, DDS_FREE_ALL);
  ddsi_serdata* serialised = nullptr;
  dds_sample_info_t info;
  FUZZ_REQUIRE(dds_takecdr(reader, &serialised, 1, &info, DDS_ANY_STATE) == 1);
  return serialised->type;  // kept alive with it
}

template <class Message>
std::optional<Message> decoded(const std::uint8_t* data, std::size_t size) {
  using Wire = wire::Type<Message>;
  static const ddsi_sertype* const type = type_of(Wire::descriptor());
  // Comes padded to four bytes from the network.
  std::vector<std::uint8_t> padded(data, data + size);
  padded.resize((size + 3) / 4 * 4);
  const ddsrt_iovec_t piece{padded.data(), static_cast<ddsrt_iov_len_t>(padded.size())};
  ddsi_serdata* serialised = ddsi_serdata_from_ser_iov(type, SDK_DATA, 1, &piece, padded.size());
  if (serialised == nullptr) return std::nullopt;
  typename Wire::Sample sample{};
  std::optional<Message> message;
  if (ddsi_serdata_to_sample(serialised, &sample, nullptr, nullptr)) message = Wire::read(sample);
  dds_sample_free(&sample, &Wire::descriptor(), DDS_FREE_CONTENTS);
  ddsi_serdata_unref(serialised);
  return message;
}

void use(const TransformMessage& message) {
  TfBuffer tf({.most_frames = 20, .most_samples = 20});
  for (const auto& transform : message.transforms) {
    tf.add(transform.header.frame, transform.child_frame, transform.header.stamp, transform.parent_from_child);
  }
  FUZZ_REQUIRE(tf.frames() <= 20 && tf.samples() <= 400);
  for (const auto& transform : message.transforms) {
    const auto pose = tf.at("world", transform.child_frame, transform.header.stamp);
    if (pose) FUZZ_REQUIRE(std::abs(glm::length(pose->rotation) - 1) < 1e-6);
  }
}

void use(const CameraInfoMessage& message) {
  const CameraModel camera = camera_from_info(message, "camera_info");
  FUZZ_REQUIRE(camera.width > 0 && camera.height > 0 && camera.focal_length.x > 0 && camera.focal_length.y > 0);
  FUZZ_REQUIRE(std::isfinite(camera.principal_point.x + camera.principal_point.y));
  for (const double k : camera.distortion) FUZZ_REQUIRE(std::isfinite(k));
}

void use(const EncodedPicture& message) {
  const bool looks = looks_like_picture(message), is_whole = looks_whole(message);
  FUZZ_REQUIRE(looks || !is_whole);
  const cv::Mat picture = decode(message, "picture", {16, 12});
  FUZZ_REQUIRE(is_whole);  // what can be decoded is never turned away before
  FUZZ_REQUIRE(picture.size() == cv::Size(16, 12) && picture.type() == CV_8UC3);
}

template <class Message>
void try_as(const std::uint8_t* data, std::size_t size) {
  const std::optional<Message> message = decoded<Message>(data, size);
  if constexpr (!std::is_same_v<Message, JointStateMessage> && !std::is_same_v<Message, PoseMessage>) {
    if (message) use(*message);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 5) return 0;
  constexpr std::array kTypes{try_as<CompressedImageMessage>, try_as<ImageMessage>, try_as<CameraInfoMessage>,
                              try_as<TransformMessage>,       try_as<PoseMessage>,  try_as<JointStateMessage>};
  try {
    kTypes[data[0] % kTypes.size()](data + 1, size - 1);
  } catch (const foreview::InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
