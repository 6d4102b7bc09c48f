#include "foreview/server/dds/dds_node.h"

#include <dds/dds.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/server/dds/wire.h"
#include "foreview/server/frame_source.h"

namespace foreview {
namespace {

constexpr int kHighestDomain = 232;  // ports: 7400 + 250 * domain

/// An entity of Cyclone's, deleted with all it contains.
class Entity {
 public:
  Entity() = default;
  Entity(dds_entity_t handle, const std::string& what) : handle_(handle) {
    if (handle < 0) throw InputError(what, std::string("DDS refuses it: ") + dds_strretcode(-handle));
  }
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  [[nodiscard]] dds_entity_t handle() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

std::string loopback_name() {
  ifaddrs* all = nullptr;
  std::string name = "lo";
  if (getifaddrs(&all) != 0) return name;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if ((one->ifa_flags & IFF_LOOPBACK) == 0) continue;
    name = one->ifa_name;
    break;
  }
  freeifaddrs(all);
  return name;
}

/// Cyclone's configuration; empty: what CYCLONEDDS_URI says.
std::string configuration(const std::string& network) {
  if (network == "any") return "";
  const bool is_loopback = network == "loopback";
  if (!is_loopback && (network.find_first_of("<>&\"'") != std::string::npos || if_nametoindex(network.c_str()) == 0)) {
    throw InputError("--network", in_quotes(network) +
                                      " is no network interface; expected loopback, any, or an "
                                      "interface of this machine");
  }
  const std::string name = is_loopback ? loopback_name() : network;
  // On loopback there is no multicast: participants look for each other at the ports of the first few. Datagrams as
  // large as the interface takes save most of the system calls of a picture; on a network they would be cut up by IP.
  // A sample's size is bounded, since whoever knows the port can announce one of 2 GiB.
  return "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"" + name + "\"/></Interfaces>" +
         (is_loopback ? "<AllowMulticast>false</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize>"
                        "<FragmentSize>64000B</FragmentSize>"
                      : "") +
         "</General>" +
         (is_loopback ? "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
                        "</MaxAutoParticipantIndex><Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>"
                      : "") +
         "<Internal><MaxSampleSize>256MiB</MaxSampleSize><SocketReceiveBufferSize min=\"default\" max=\"8MiB\"/>"
         "</Internal></Domain></CycloneDDS>";
}

/// Messages of each topic that Cyclone could not decode. It tells of them nowhere but in its log.
class Undecodable {
 public:
  static Undecodable& instance() {
    static Undecodable all;
    return all;
  }
  std::shared_ptr<std::atomic<std::size_t>> of(const std::string& topic) {
    const std::lock_guard lock(mutex_);
    auto& count = topics_[topic];
    if (!count) count = std::make_shared<std::atomic<std::size_t>>(0);
    return count;
  }
  /// "data(application, vendor 1.16): GUID #NUMBER: deserialization TOPIC/TYPE failed (WHY)"
  void read_log(std::string_view line) {
    constexpr std::string_view kBefore = ": deserialization ";
    const std::size_t at = line.find(kBefore);
    if (at == std::string_view::npos || line.find(" failed") == std::string_view::npos) return;
    const std::string_view rest = line.substr(at + kBefore.size());
    // Types' names have no slash.
    const auto topic = std::string(rest.substr(0, rest.substr(0, rest.find(' ')).rfind('/')));
    const std::lock_guard lock(mutex_);
    if (const auto known = topics_.find(topic); known != topics_.end()) ++*known->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<std::atomic<std::size_t>>> topics_;
};

void log_line(void* /*unused*/, const dds_log_data_t* data) {
  std::string line(data->message, data->size);
  while (!line.empty() && line.back() == '\n') line.pop_back();
  if ((data->priority & DDS_LC_WARNING) != 0) Undecodable::instance().read_log(line);
  spdlog::log((data->priority & (DDS_LC_ERROR | DDS_LC_FATAL)) != 0 ? spdlog::level::warn : spdlog::level::debug,
              "DDS: {}", line);
}

/// A process has one instance of a domain; the first to need it decides on the network.
std::shared_ptr<Entity> join_domain(const DdsOptions& options) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Entity>> domains;
  const std::lock_guard lock(mutex);
  if (auto there = domains[options.domain].lock()) return there;
  dds_set_log_sink(log_line, nullptr);
  const std::string config = configuration(options.network);
  auto domain = config.empty() ? std::make_shared<Entity>()
                               : std::make_shared<Entity>(
                                     dds_create_domain(static_cast<dds_domainid_t>(options.domain), config.c_str()),
                                     "domain " + std::to_string(options.domain));
  domains[options.domain] = domain;
  return domain;
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos make_qos(QosProfile profile, bool is_writer) {
  Qos qos(dds_create_qos());
  const bool is_reliable = profile != QosProfile::sensor_data;
  dds_qset_reliability(qos.get(), is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_MSECS(100));
  const bool is_static = profile == QosProfile::static_transforms;
  dds_qset_durability(qos.get(), is_static ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const int depth = profile == QosProfile::sensor_data ? 5 : profile == QosProfile::reliable ? 10 : 100;
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  if (is_writer) {
    // ROS 2 reads the first encoding only.
    const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos.get(), 1, &representation);
    dds_qset_writer_data_lifecycle(qos.get(), false);
  }
  return qos;
}

std::string wire_topic(const std::string& topic) {
  const std::string name = topic.substr(topic.starts_with('/') ? 1 : 0);
  const bool is_sound =
      !name.empty() && name.size() < 240 && name.back() != '/' &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_/") == std::string::npos &&
      name.find("//") == std::string::npos;
  if (!is_sound) {
    throw InputError("topic " + in_quotes(topic), "is no name of a ROS 2 topic; expected letters, digits, _ and /");
  }
  return "rt/" + name;
}

Timestamp wall_now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count()};
}

template <class Message>
class Reader final : public DdsReader {
 public:
  using Callback = std::function<void(Message&&, const Reception&)>;
  Reader(dds_entity_t participant, const std::string& topic, QosProfile profile, Callback callback)
      : topic_name_(wire_topic(topic)),
        callback_(std::move(callback)),
        undecodable_(Undecodable::instance().of(topic_name_)),
        undecodable_before_(*undecodable_) {
    topic_ =
        Entity(dds_create_topic(participant, &wire::Type<Message>::descriptor(), topic_name_.c_str(), nullptr, nullptr),
               "topic " + topic);
    dds_listener_t* listener = dds_create_listener(this);
    dds_lset_data_available(listener,
                            [](dds_entity_t reader, void* self) { static_cast<Reader*>(self)->take(reader); });
    const Qos qos = make_qos(profile, false);
    reader_ = Entity(dds_create_reader(participant, topic_.handle(), qos.get(), listener), "topic " + topic);
    dds_delete_listener(listener);
  }

  std::size_t publishers() const override {
    dds_subscription_matched_status_t status{};
    return dds_get_subscription_matched_status(reader_.handle(), &status) == DDS_RETCODE_OK ? status.current_count : 0;
  }
  std::size_t lost() const override {
    dds_sample_lost_status_t status{};
    const bool is_known = dds_get_sample_lost_status(reader_.handle(), &status) == DDS_RETCODE_OK;
    return (is_known ? status.total_count : 0) + (*undecodable_ - undecodable_before_);
  }

 private:
  void take(dds_entity_t reader) {
    const Reception now{steady_now(), wall_now(), 0};
    while (true) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      const dds_return_t count = dds_take(reader, &sample, &info, 1, 1);
      if (count <= 0) return;
      if (info.valid_data) {
        Reception reception = now;
        reception.publisher = info.publication_handle;
        try {
          callback_(wire::Type<Message>::read(*static_cast<const typename wire::Type<Message>::Sample*>(sample)),
                    reception);
        } catch (const std::exception& error) {
          spdlog::warn("{}: message dropped: {}", topic_name_, error.what());
        }
      }
      dds_return_loan(reader, &sample, count);
    }
  }

  /// Handles are given anew whenever a writer is found again; its GUID stays.
  std::uint64_t publisher(dds_entity_t reader, dds_instance_handle_t handle) {
    for (const auto& [known, id] : publishers_) {
      if (known == handle) return id;
    }
    dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, handle);
    if (endpoint == nullptr) return 0;
    std::uint64_t id = 0xcbf29ce484222325U;  // FNV-1a
    for (const std::uint8_t byte : endpoint->key.v) id = (id ^ byte) * 0x100000001b3U;
    dds_builtintopic_free_endpoint(endpoint);
    constexpr std::size_t kMostRemembered = 16;
    if (publishers_.size() == kMostRemembered) publishers_.erase(publishers_.begin());
    publishers_.emplace_back(handle, id);
    return id;
  }

  std::string topic_name_;
  Callback callback_;
  std::shared_ptr<const std::atomic<std::size_t>> undecodable_;  ///< of the topic
  std::size_t undecodable_before_;
  std::vector<std::pair<dds_instance_handle_t, std::uint64_t>> publishers_;  ///< of the callback's thread
  Entity topic_;
  Entity reader_;  ///< deleted first: waits for a callback that is running
};

template <class Message>
class Writer final : public DdsWriter<Message> {
 public:
  Writer(dds_entity_t participant, const std::string& topic, QosProfile profile) : topic_name_(wire_topic(topic)) {
    topic_ =
        Entity(dds_create_topic(participant, &wire::Type<Message>::descriptor(), topic_name_.c_str(), nullptr, nullptr),
               "topic " + topic);
    const Qos qos = make_qos(profile, true);
    writer_ = Entity(dds_create_writer(participant, topic_.handle(), qos.get(), nullptr), "topic " + topic);
  }

  void write(const Message& message) override {
    wire::Lending lending;
    const auto sample = wire::Type<Message>::lend(message, lending);
    const dds_return_t result = dds_write(writer_.handle(), &sample);
    // A reader that does not keep up makes a reliable writer give up after a while: its loss, not the end of sending.
    if (result == DDS_RETCODE_TIMEOUT) return;
    if (result != DDS_RETCODE_OK) throw InputError(topic_name_, std::string("not sent: ") + dds_strretcode(-result));
  }

  std::size_t subscribers() const override {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer_.handle(), &status) == DDS_RETCODE_OK ? status.current_count : 0;
  }

 private:
  std::string topic_name_;
  Entity topic_, writer_;
};

}  // namespace

int default_dds_domain() {
  const char* const text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  const std::string_view view(text);
  int domain = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), domain);
  if (error != std::errc() || end != view.data() + view.size() || domain < 0 || domain > kHighestDomain) {
    throw InputError("ROS_DOMAIN_ID", in_quotes(view) + " is no domain; expected 0 to 232");
  }
  return domain;
}

struct DdsNode::State {
  std::shared_ptr<Entity> domain;
  Entity participant;
};

DdsNode::DdsNode(const DdsOptions& options) : state_(std::make_shared<State>()) {
  if (options.domain < 0 || options.domain > kHighestDomain) {
    throw InputError("domain " + std::to_string(options.domain), "is out of range; expected 0 to 232");
  }
  state_->domain = join_domain(options);
  state_->participant = Entity(dds_create_participant(static_cast<dds_domainid_t>(options.domain), nullptr, nullptr),
                               "network " + options.network);
}
DdsNode::~DdsNode() = default;

template <class Message>
std::unique_ptr<DdsReader> DdsNode::subscribe(const std::string& topic, QosProfile qos,
                                              std::function<void(Message&&, const Reception&)> callback) {
  return std::make_unique<Reader<Message>>(state_->participant.handle(), topic, qos, std::move(callback));
}

template <class Message>
std::unique_ptr<DdsWriter<Message>> DdsNode::advertise(const std::string& topic, QosProfile qos) {
  return std::make_unique<Writer<Message>>(state_->participant.handle(), topic, qos);
}

// NOLINTBEGIN(bugprone-macro-parentheses): a type cannot stand in parentheses
#define FOREVIEW_INSTANTIATE(Message)                                                                                \
  template std::unique_ptr<DdsReader> DdsNode::subscribe<Message>(const std::string&, QosProfile,                    \
                                                                  std::function<void(Message&&, const Reception&)>); \
  template std::unique_ptr<DdsWriter<Message>> DdsNode::advertise<Message>(const std::string&, QosProfile)
FOREVIEW_INSTANTIATE(CompressedImageMessage);
FOREVIEW_INSTANTIATE(ImageMessage);
FOREVIEW_INSTANTIATE(CameraInfoMessage);
FOREVIEW_INSTANTIATE(JointStateMessage);
FOREVIEW_INSTANTIATE(TransformMessage);
FOREVIEW_INSTANTIATE(PoseMessage);
FOREVIEW_INSTANTIATE(TextMessage);
#undef FOREVIEW_INSTANTIATE
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace foreview
