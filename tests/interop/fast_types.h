#pragma once
// ROS 2's types for Fast DDS, written by hand (Debian does not package its code generator) from the definitions of
// ROS 2's messages, and on purpose without anything of server/: an error there must not be made here again.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

namespace fast {

using eprosima::fastcdr::Cdr;

struct Header {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id;
};
struct CompressedImage {
  static constexpr const char* kName = "sensor_msgs::msg::dds_::CompressedImage_";
  Header header;
  std::string format;
  std::vector<std::uint8_t> data;
};
struct Image {
  static constexpr const char* kName = "sensor_msgs::msg::dds_::Image_";
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;
};
struct CameraInfo {
  static constexpr const char* kName = "sensor_msgs::msg::dds_::CameraInfo_";
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{}, r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0, binning_y = 0;
  std::uint32_t x_offset = 0, y_offset = 0, roi_height = 0, roi_width = 0;
  bool do_rectify = false;
};
struct JointState {
  static constexpr const char* kName = "sensor_msgs::msg::dds_::JointState_";
  Header header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
};
struct TransformStamped {
  Header header;
  std::string child_frame_id;
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{};  ///< x, y, z, w
};
struct TFMessage {
  static constexpr const char* kName = "tf2_msgs::msg::dds_::TFMessage_";
  std::vector<TransformStamped> transforms;
};

inline Cdr& operator<<(Cdr& c, const Header& h) {
  return c << h.sec << h.nanosec << h.frame_id;
}
inline Cdr& operator>>(Cdr& c, Header& h) {
  return c >> h.sec >> h.nanosec >> h.frame_id;
}
inline Cdr& operator<<(Cdr& c, const CompressedImage& m) {
  return c << m.header << m.format << m.data;
}
inline Cdr& operator>>(Cdr& c, CompressedImage& m) {
  return c >> m.header >> m.format >> m.data;
}
inline Cdr& operator<<(Cdr& c, const Image& m) {
  return c << m.header << m.height << m.width << m.encoding << m.is_bigendian << m.step << m.data;
}
inline Cdr& operator>>(Cdr& c, Image& m) {
  return c >> m.header >> m.height >> m.width >> m.encoding >> m.is_bigendian >> m.step >> m.data;
}
inline Cdr& operator<<(Cdr& c, const CameraInfo& m) {
  return c << m.header << m.height << m.width << m.distortion_model << m.d << m.k << m.r << m.p << m.binning_x
           << m.binning_y << m.x_offset << m.y_offset << m.roi_height << m.roi_width << m.do_rectify;
}
inline Cdr& operator>>(Cdr& c, CameraInfo& m) {
  return c >> m.header >> m.height >> m.width >> m.distortion_model >> m.d >> m.k >> m.r >> m.p >> m.binning_x >>
         m.binning_y >> m.x_offset >> m.y_offset >> m.roi_height >> m.roi_width >> m.do_rectify;
}
inline Cdr& operator<<(Cdr& c, const JointState& m) {
  return c << m.header << m.name << m.position << m.velocity << m.effort;
}
inline Cdr& operator>>(Cdr& c, JointState& m) {
  return c >> m.header >> m.name >> m.position >> m.velocity >> m.effort;
}
inline Cdr& operator<<(Cdr& c, const TFMessage& m) {
  c << static_cast<std::uint32_t>(m.transforms.size());
  for (const TransformStamped& t : m.transforms) c << t.header << t.child_frame_id << t.translation << t.rotation;
  return c;
}
inline Cdr& operator>>(Cdr& c, TFMessage& m) {
  std::uint32_t count = 0;
  c >> count;
  m.transforms.resize(count);
  for (TransformStamped& t : m.transforms) c >> t.header >> t.child_frame_id >> t.translation >> t.rotation;
  return c;
}

template <class Message>
class TypeSupport : public eprosima::fastdds::dds::TopicDataType {
 public:
  TypeSupport() {
    setName(Message::kName);
    m_typeSize = 1024;  // to begin with; grows with the messages
    m_isGetKeyDefined = false;
    // As ROS 2: types match by name.
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const std::vector<char> bytes = encoded(*static_cast<Message*>(data));
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
      Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
      cdr.read_encapsulation();
      cdr >> *static_cast<Message*>(data);
      return true;
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(encoded(*static_cast<Message*>(data)).size()); };
  }
  void* createData() override { return new Message; }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  static std::vector<char> encoded(const Message& message) {
    eprosima::fastcdr::FastBuffer buffer;
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    cdr << message;
    return {cdr.getBufferPointer(), cdr.getBufferPointer() + cdr.getSerializedDataLength()};
  }
};

}  // namespace fast
