#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "foreview/scene/timestamp.h"
#include "foreview/server/dds/messages.h"

namespace foreview {

/// ROS 2's usual quality of service, as publishers offer and subscribers ask for it. Best effort asks for less than
/// reliable offers, so a best-effort reader hears either; a reliable reader hears reliable writers only.
enum class QosProfile {
  sensor_data,        ///< best effort, volatile, keep last 5
  reliable,           ///< reliable, volatile, keep last 10: rclcpp's default
  transforms,         ///< reliable, volatile, keep last 100: rt/tf
  static_transforms,  ///< reliable, transient local, keep last 100: rt/tf_static
};

struct DdsOptions {
  int domain = 0;  ///< ROS_DOMAIN_ID, 0 to 232
  /// "loopback": this machine only; "any": as Cyclone DDS chooses, or CYCLONEDDS_URI says; else a network interface.
  std::string network = "loopback";
};
/// ROS_DOMAIN_ID from the environment, else 0. InputError where it is no domain.
[[nodiscard]] int default_dds_domain();

/// When a message came.
struct Reception {
  Timestamp steady;  ///< steady_now() when its last packet had arrived
  Timestamp wall;    ///< the same in Unix time
  /// Tells publishers apart: of the writer's GUID, so that one who was silent, or cut off, is himself when he returns,
  /// and one who was started again is another. 0: not known.
  std::uint64_t publisher = 0;
};

/// Hears one topic until it is destroyed; afterwards, its callback does not run any more.
class DdsReader {
 public:
  virtual ~DdsReader() = default;
  [[nodiscard]] virtual std::size_t publishers() const = 0;  ///< heard now
  /// Messages that did not become valid: damaged on the way or not decodable, or lost before a reliable writer could
  /// repeat them.
  [[nodiscard]] virtual std::size_t lost() const = 0;
};

template <class Message>
class DdsWriter {
 public:
  virtual ~DdsWriter() = default;
  /// Sends at once. Throws InputError naming the topic where the network refuses.
  virtual void write(const Message& message) = 0;
  [[nodiscard]] virtual std::size_t subscribers() const = 0;
};

/// A participant of a DDS domain that speaks ROS 2's types. `topic` as in ROS 2: "/camera/image/compressed" or without
/// the first slash; on the wire it is "rt/camera/...". Thread-safe. Throws InputError where the network, or a topic's
/// name, cannot be used.
class DdsNode {
 public:
  explicit DdsNode(const DdsOptions& options);
  ~DdsNode();
  DdsNode(const DdsNode&) = delete;
  DdsNode& operator=(const DdsNode&) = delete;

  /// `callback` runs in a thread of the network's: brief, and the next message waits for it. What it throws is logged.
  /// For the message types of messages.h.
  template <class Message>
  [[nodiscard]] std::unique_ptr<DdsReader> subscribe(const std::string& topic, QosProfile qos,
                                                     std::function<void(Message&&, const Reception&)> callback);
  template <class Message>
  [[nodiscard]] std::unique_ptr<DdsWriter<Message>> advertise(const std::string& topic, QosProfile qos);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace foreview
