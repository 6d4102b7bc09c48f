#include "foreview/server/recording_sender.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "foreview/recordings/picture_file.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/frame_source.h"

namespace foreview {
namespace {

constexpr const char* kWorld = "world";

/// What is sent at one moment, in this order.
enum class Kind { camera_pose, part_pose, joints, picture };
struct SendEvent {
  Timestamp stamp;
  Kind kind = Kind::picture;
  std::size_t which = 0;  ///< camera, or part
  std::size_t index = 0;  ///< of the picture, or the joints' sample
};

/// Letters, digits and underscores, as ROS 2's names want it.
std::string topic_name(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    result += is_plain ? c : '_';
  }
  return result.empty() ? "camera" : result;
}

Timestamp wall_now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count()};
}

}  // namespace

struct RecordingSender::State {
  struct Camera {
    std::unique_ptr<DdsWriter<CompressedImageMessage>> pictures;
    std::unique_ptr<DdsWriter<CameraInfoMessage>> info;
    CameraInfoMessage info_message;
    std::string frame;
  };

  State(const Recording& recording_in, DdsNode& node, Options options_in)
      : recording(recording_in), options(std::move(options_in)) {
    if (!(options.speed >= 0.01 && options.speed <= 100)) {
      throw InputError("--speed", number_text(options.speed) + " is out of range; expected 0.01 to 100");
    }
    const QosProfile qos = options.is_reliable ? QosProfile::reliable : QosProfile::sensor_data;
    for (const Recording::Camera& camera : recording.cameras()) {
      const std::string image = image_topic(camera.name);
      cameras.push_back({node.advertise<CompressedImageMessage>(image, qos),
                         node.advertise<CameraInfoMessage>("/" + topic_name(camera.name) + "/camera_info", qos),
                         info_from_camera(camera.model), RecordingSender::frame(camera.name)});
    }
    tf = node.advertise<TransformMessage>("/tf", QosProfile::transforms);
    tf_static = node.advertise<TransformMessage>("/tf_static", QosProfile::static_transforms);
    if (!recording.joints().names.empty()) {
      joints = node.advertise<JointStateMessage>("/joint_states", QosProfile::reliable);
    }
    for (const auto& [name, trajectory] : recording.part_trajectories()) parts.emplace_back(name, &trajectory);
    collect();
  }

  void collect() {
    std::set<std::pair<Timestamp, std::size_t>> camera_poses, part_poses;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const Recording::Camera& camera = recording.cameras()[c];
      for (const auto& sample : camera.world_from_camera.samples()) camera_poses.insert({sample.stamp, c});
      for (std::size_t i = 0; i < camera.pictures.size(); ++i) {
        const Timestamp stamp = camera.pictures[i].stamp;
        events.push_back({stamp, Kind::picture, c, i});
        camera_poses.insert({stamp, c});
        for (std::size_t p = 0; p < parts.size(); ++p) {
          if (parts[p].second->size() > 1 && parts[p].second->at(stamp)) part_poses.insert({stamp, p});
        }
      }
    }
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (parts[p].second->size() == 1) continue;
      for (const auto& sample : parts[p].second->samples()) part_poses.insert({sample.stamp, p});
    }
    for (const auto& [stamp, camera] : camera_poses) events.push_back({stamp, Kind::camera_pose, camera, 0});
    for (const auto& [stamp, part] : part_poses) events.push_back({stamp, Kind::part_pose, part, 0});
    for (std::size_t i = 0; i < recording.joints().stamps.size(); ++i) {
      events.push_back({recording.joints().stamps[i], Kind::joints, 0, i});
    }
    std::sort(events.begin(), events.end(), [](const SendEvent& a, const SendEvent& b) {
      return std::tie(a.stamp, a.kind, a.which, a.index) < std::tie(b.stamp, b.kind, b.which, b.index);
    });
  }

  void send_static() {
    TransformMessage message;
    for (const auto& [name, trajectory] : parts) {
      if (trajectory->size() != 1) continue;
      const auto& sample = trajectory->samples().front();
      message.transforms.push_back({{sample.stamp + shift, kWorld}, name, sample.pose});
    }
    if (!message.transforms.empty()) tf_static->write(message);
  }

  void send_picture(const SendEvent& event) {
    Camera& camera = cameras[event.which];
    const Recording::PictureEntry& entry = recording.cameras()[event.which].pictures[event.index];
    const MessageHeader header{event.stamp + shift, camera.frame};
    CompressedImageMessage message{header, entry.file.extension() == ".png" ? "png" : "jpeg", {}};
    try {
      const std::string bytes = read_input_file(entry.file, kMostPictureBytes);
      message.data.assign(bytes.begin(), bytes.end());
    } catch (const InputError& error) {
      spdlog::log(summary.unreadable++ == 0 ? spdlog::level::warn : spdlog::level::debug, "not sent: {}", error.what());
      return;
    }
    camera.info_message.header = header;
    camera.info->write(camera.info_message);
    if (options.before_sending) options.before_sending(message);
    camera.pictures->write(message);
    ++summary.pictures;
  }

  void send(const SendEvent& event) {
    if (event.kind == Kind::picture) return send_picture(event);
    if (event.kind == Kind::joints) {
      joints->write({{event.stamp + shift, ""}, recording.joints().names, recording.joints().positions[event.index]});
      return;
    }
    const bool is_camera = event.kind == Kind::camera_pose;
    const Trajectory& trajectory =
        is_camera ? recording.cameras()[event.which].world_from_camera : *parts[event.which].second;
    const std::string& child = is_camera ? cameras[event.which].frame : parts[event.which].first;
    if (const auto pose = trajectory.at(event.stamp)) {
      tf->write({{{{event.stamp + shift, kWorld}, child, *pose}}});
    }
  }

  /// False: told to stop.
  static bool wait_until(Timestamp steady, const std::function<bool()>& goes_on) {
    while (true) {
      if (!goes_on()) return false;
      const std::int64_t left = (steady - steady_now()).nanoseconds;
      if (left <= 0) return true;
      std::this_thread::sleep_for(std::chrono::nanoseconds(std::min<std::int64_t>(left, 100'000'000)));
    }
  }

  const Recording& recording;
  Options options;
  std::vector<Camera> cameras;
  std::vector<std::pair<std::string, const Trajectory*>> parts;
  std::unique_ptr<DdsWriter<TransformMessage>> tf, tf_static;
  std::unique_ptr<DdsWriter<JointStateMessage>> joints;
  std::vector<SendEvent> events;
  Duration shift;  ///< of the stamps sent
  Summary summary;
};

RecordingSender::RecordingSender(const Recording& recording, DdsNode& node, Options options)
    : state_(std::make_unique<State>(recording, node, std::move(options))) {}
RecordingSender::~RecordingSender() = default;

std::string RecordingSender::image_topic(const std::string& camera) {
  return "/" + topic_name(camera) + "/image_raw/compressed";
}

std::string RecordingSender::frame(const std::string& camera) {
  return topic_name(camera) + "_optical_frame";
}

bool RecordingSender::is_heard() const {
  return state_->tf->subscribers() > 0 &&
         std::all_of(state_->cameras.begin(), state_->cameras.end(), [](const State::Camera& camera) {
           return camera.pictures->subscribers() > 0 && camera.info->subscribers() > 0;
         });
}

RecordingSender::Summary RecordingSender::run(const std::function<bool()>& goes_on) {
  State& state = *state_;
  const std::vector<SendEvent>& events = state.events;
  const Timestamp first = events.front().stamp, last = events.back().stamp;
  if (!state.options.keeps_stamps) state.shift = wall_now() - first;
  state.send_static();
  Timestamp begin = steady_now();
  do {
    for (const SendEvent& event : events) {
      const Duration since = Duration::from_seconds((event.stamp - first).seconds() / state.options.speed);
      if (!State::wait_until(begin + since, goes_on)) return state.summary;
      state.send(event);
    }
    // The next round begins where this one ended, in the time between two pictures.
    const auto& camera = state.recording.cameras().front();
    const auto intervals = static_cast<std::int64_t>(std::max<std::size_t>(camera.pictures.size(), 2) - 1);
    const Duration gap{std::max<std::int64_t>(
        (state.recording.last_stamp() - state.recording.first_stamp()).nanoseconds / intervals, 1'000'000)};
    const Duration round = last - first + gap;
    state.shift = state.shift + round;
    begin = begin + Duration::from_seconds(round.seconds() / state.options.speed);
  } while (state.options.loop);
  return state.summary;
}

}  // namespace foreview
