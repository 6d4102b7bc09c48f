#pragma once
// Between messages and what the IDL compiler makes of ros2_messages.idl. Included by nothing but this folder's sources
// and the fuzz target: whoever includes it needs Cyclone DDS and the generated header.
#include <ros2_messages.h>

#include "foreview/server/dds/messages.h"

namespace foreview::wire {

/// Of each message: the generated type, its descriptor, reading a sample, and lending a message's memory to one.
template <class Message>
struct Type;

/// What a lent sample needs beside the message itself; both must outlive it.
struct Lending {
  std::vector<char*> strings;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms;
};

#define FOREVIEW_WIRE_TYPE(Message, Generated)                                     \
  template <>                                                                      \
  struct Type<Message> {                                                           \
    using Sample = Generated;                                                      \
    static const dds_topic_descriptor_t& descriptor() { return Generated##_desc; } \
    static Message read(const Sample& sample);                                     \
    /* The sample must not be freed: what it points to is the message's. */        \
    static Sample lend(const Message& message, Lending& lending);                  \
  }
FOREVIEW_WIRE_TYPE(CompressedImageMessage, sensor_msgs_msg_dds__CompressedImage_);
FOREVIEW_WIRE_TYPE(ImageMessage, sensor_msgs_msg_dds__Image_);
FOREVIEW_WIRE_TYPE(CameraInfoMessage, sensor_msgs_msg_dds__CameraInfo_);
FOREVIEW_WIRE_TYPE(JointStateMessage, sensor_msgs_msg_dds__JointState_);
FOREVIEW_WIRE_TYPE(TransformMessage, tf2_msgs_msg_dds__TFMessage_);
FOREVIEW_WIRE_TYPE(PoseMessage, geometry_msgs_msg_dds__PoseStamped_);
FOREVIEW_WIRE_TYPE(TextMessage, std_msgs_msg_dds__String_);
#undef FOREVIEW_WIRE_TYPE

}  // namespace foreview::wire
