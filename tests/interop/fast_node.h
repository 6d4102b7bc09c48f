#pragma once
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "fast_types.h"

namespace fast {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

/// A participant of Fast DDS on this machine's loopback interface: what ROS_LOCALHOST_ONLY=1 makes of a ROS 2 node.
class Node {
 public:
  explicit Node(int domain) {
    dds::DomainParticipantQos qos;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {"127.0.0.1"};
    udp->maxInitialPeersRange = 10;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports = {udp};
    rtps::Locator_t peer;
    rtps::IPLocator::setIPv4(peer, 127, 0, 0, 1);
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
    participant_ =
        dds::DomainParticipantFactory::get_instance()->create_participant(static_cast<dds::DomainId_t>(domain), qos);
    if (participant_ == nullptr) throw std::runtime_error("Fast DDS: no participant");
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  ~Node() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  template <class Message>
  dds::DataWriter* advertise(const std::string& topic, bool is_reliable, bool is_static = false) {
    dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = is_static ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().depth = 10;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return publisher_->create_datawriter(make_topic<Message>(topic), qos);
  }
  template <class Message>
  dds::DataReader* subscribe(const std::string& topic, bool is_reliable, bool is_static = false) {
    dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = is_static ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().depth = 10;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return subscriber_->create_datareader(make_topic<Message>(topic), qos);
  }

 private:
  template <class Message>
  dds::Topic* make_topic(const std::string& name) {
    dds::TypeSupport(new TypeSupport<Message>).register_type(participant_);
    return participant_->create_topic(name, Message::kName, dds::TOPIC_QOS_DEFAULT);
  }

  dds::DomainParticipant* participant_;
  dds::Publisher* publisher_;
  dds::Subscriber* subscriber_;
};

/// The next message, if one has come.
template <class Message>
std::optional<Message> take(dds::DataReader* reader) {
  Message message;
  dds::SampleInfo info;
  while (reader->take_next_sample(&message, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
    if (info.valid_data) return message;
  }
  return std::nullopt;
}

}  // namespace fast
