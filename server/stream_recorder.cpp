#include "foreview/server/stream_recorder.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/stream_restart.h"
#include "foreview/server/tf_buffer.h"
#include "foreview/server/thread_priority.h"

namespace foreview {
namespace {

struct Waiting {
  std::size_t camera = 0;
  EncodedPicture picture;
  Timestamp arrived;  ///< steady
};

constexpr std::size_t kMostWaiting = 100'000;  // poses, joint states

/// One pose that the recording gets.
struct PoseSample {
  std::size_t camera = 0;
  std::string part;  ///< else this part's
  Timestamp stamp;
  Pose pose;
};

bool is_png(const std::vector<std::uint8_t>& data) {
  return data.size() > 3 && data[0] == 0x89 && data[1] == 'P' && data[2] == 'N' && data[3] == 'G';
}

}  // namespace

struct StreamRecorder::State {
  explicit State(Options options_in) : options(std::move(options_in)) {
    if (options.cameras.empty()) throw InputError("record", "has no camera; expected at least one");
    for (const StreamRecorder::Camera& camera : options.cameras) frames.push_back(camera.frame);
    models.resize(options.cameras.size());
    restarts.resize(options.cameras.size());
    newest_stamp.resize(options.cameras.size());
    last_pose.resize(options.cameras.size());
    tf = TfBuffer({.memory = options.state_wait + Duration{10'000'000'000}});
    worker = std::thread([this] { work_until_stopped(); });
  }

  ~State() { stop(); }

  void stop() {
    {
      const std::lock_guard lock(mutex);
      is_stopping = true;
    }
    work.notify_all();
    if (worker.joinable()) worker.join();
  }

  [[nodiscard]] std::string camera_frame(std::size_t camera) const {
    return options.cameras[camera].has_pose_topic ? "pose of camera " + std::to_string(camera) : frames[camera];
  }

  // With `mutex` held.

  /// Notes every new step of the poses that are recorded.
  void note_poses() {
    // Before the recording begins none are written; the oldest go then.
    while (poses.size() > kMostWaiting) poses.pop_front();
    for (std::size_t camera = 0; camera < frames.size(); ++camera) {
      if (const auto sample = step(camera_frame(camera), last_pose[camera])) {
        poses.push_back({camera, "", sample->first, sample->second});
      }
    }
    for (const std::string& part : options.parts) {
      if (!tf.has(part)) continue;
      if (const auto sample = step(part, last_part_pose[part]))
        poses.push_back({0, part, sample->first, sample->second});
    }
  }

  [[nodiscard]] std::optional<std::pair<Timestamp, Pose>> step(const std::string& frame,
                                                               std::optional<Timestamp>& last) const {
    // Where nothing moves there is no step: the newest picture's stamp stands in.
    const std::optional<Timestamp> newest = tf.newest(options.world_frame, frame, newest_picture);
    if (!newest || (last && *newest <= *last)) return std::nullopt;
    const std::optional<Pose> pose = tf.at(options.world_frame, frame, *newest);
    if (!pose) return std::nullopt;
    last = newest;
    return std::pair(*newest, *pose);
  }

  /// Whether a picture comes after those before it in the one time that a recording has. What does not is counted;
  /// where the stream begins anew the recording ends.
  bool follows(std::size_t camera, const EncodedPicture& picture, bool is_picture, const Reception& reception) {
    if (!is_picture) {
      ++counts.damaged;
      return false;
    }
    const Timestamp stamp = header_of(picture).stamp;
    const StreamRestart::Verdict verdict = restarts.at(camera).note(stamp, reception.publisher, reception.steady);
    if (verdict == StreamRestart::Verdict::begins_anew) {
      ending = options.cameras[camera].name +
               ": the stream began anew (sender restarted, or its clock set back); a recording has one time";
      is_stopping = true;
      ++counts.unwritten;
      return false;
    }
    // Else it would get the poses that were known at this stamp, which may be those of another clock.
    std::optional<Timestamp>& newest = newest_stamp[camera];
    if (verdict == StreamRestart::Verdict::straggles || (newest && stamp <= *newest)) {
      ++counts.late;
      return false;
    }
    newest = stamp;
    return true;
  }

  [[nodiscard]] bool is_ready(const Waiting& item) const {
    const Timestamp stamp = header_of(item.picture).stamp;
    const auto& newest = last_pose[item.camera];
    if (!newest || *newest < stamp) return false;
    return std::all_of(options.parts.begin(), options.parts.end(), [&](const std::string& part) {
      const auto place = last_part_pose.find(part);
      return place == last_part_pose.end() || (place->second && *place->second >= stamp);
    });
  }

  [[nodiscard]] std::string waiting_for() const {
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (!models[i]) return "camera_info of " + options.cameras[i].name;
    }
    return "";
  }

  void work_until_stopped() {
    lower_thread_priority();
    std::unique_lock lock(mutex);
    while (counts.error.empty()) {
      if (!waiting_for().empty()) {
        if (is_stopping) break;
        work.wait_for(lock, std::chrono::milliseconds(100));
        continue;
      }
      std::deque<PoseSample> some_poses;
      some_poses.swap(poses);
      std::deque<JointStateMessage> some_joints;
      some_joints.swap(joints);
      std::vector<Waiting> some_pictures;
      const Timestamp now = steady_now();
      for (std::size_t i = 0; i < waiting.size();) {
        const bool ready = is_ready(waiting[i]);
        if (!ready && now - waiting[i].arrived < options.state_wait && !is_stopping) {
          ++i;
          continue;
        }
        waiting_bytes -= bytes_of(waiting[i].picture);
        if (ready) {
          some_pictures.push_back(std::move(waiting[i]));
        } else {
          ++counts.stateless;
        }
        waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(i));
      }
      if (some_poses.empty() && some_joints.empty() && some_pictures.empty()) {
        if (is_stopping) break;
        work.wait_for(lock, std::chrono::milliseconds(100));
        continue;
      }
      lock.unlock();
      std::size_t damaged = 0, written = 0;
      std::string error;
      try {
        write(some_poses, some_joints, some_pictures, damaged);
      } catch (const InputError& failure) {
        error = failure.what();
      }
      try {
        // Also of what was written before an error.
        if (writer) written = writer->commit();
      } catch (const InputError& failure) {
        if (error.empty()) error = failure.what();
      }
      lock.lock();
      counts.written += written;
      counts.damaged += damaged;
      counts.error = error;
      if (!error.empty()) counts.unwritten += some_pictures.size() - written - damaged;
    }
    if (counts.error.empty()) counts.error = ending;
    // After an error, or where it never began, nobody takes what still waits.
    counts.unwritten += waiting.size();
    waiting.clear();
    waiting_bytes = 0;
  }

  // Without `mutex`, in the worker.

  void write(const std::deque<PoseSample>& some_poses, const std::deque<JointStateMessage>& some_joints,
             const std::vector<Waiting>& some_pictures, std::size_t& damaged) {
    if (!writer) open_writer();
    for (const PoseSample& sample : some_poses) {
      if (sample.part.empty()) {
        writer->add_camera_pose(sample.camera, sample.stamp, sample.pose);
      } else {
        writer->add_part_pose(sample.part, sample.stamp, sample.pose);
      }
    }
    for (const JointStateMessage& message : some_joints) write_joints(message);
    for (const Waiting& picture : some_pictures) damaged += write_picture(picture) ? 0 : 1;
  }

  void open_writer() {
    RecordingWriter::Description description;
    description.name = options.name;
    description.scene_file = options.scene_file;
    for (std::size_t i = 0; i < options.cameras.size(); ++i) {
      recorded.push_back(*models[i]);
      recorded.back().name = options.cameras[i].name;
      description.cameras.push_back({options.cameras.size() == 1 ? "" : options.cameras[i].name, recorded.back()});
    }
    description.is_durable = true;
    description.disk = options.disk;
    writer.emplace(options.directory, description);
  }

  bool write_picture(const Waiting& item) {
    const CameraModel& camera = recorded[item.camera];
    const Timestamp stamp = header_of(item.picture).stamp;
    cv::Mat picture;
    try {
      picture = decode(item.picture, options.cameras[item.camera].name, {camera.width, camera.height});
    } catch (const std::exception& error) {
      spdlog::log(has_told_damage ? spdlog::level::debug : spdlog::level::warn, "picture not recorded: {}",
                  error.what());
      has_told_damage = true;
      return false;
    }
    if (const auto* compressed = std::get_if<CompressedImageMessage>(&item.picture)) {
      writer->add_encoded_picture(item.camera, stamp, compressed->data, is_png(compressed->data) ? "png" : "jpg");
    } else {
      writer->add_picture(item.camera, stamp, picture, "png");
    }
    return true;
  }

  /// Of the names that the first message has; a message without one of them is left out.
  void write_joints(const JointStateMessage& message) {
    if (message.position.size() != message.name.size()) return;
    if (joint_names.empty()) {
      for (const std::string& name : message.name) {
        if (!name.empty() && name.find_first_of(",\r\n") == std::string::npos) joint_names.push_back(name);
      }
      if (joint_names.empty()) return;
      writer->set_joint_names(joint_names);
    }
    std::vector<double> positions;
    for (const std::string& name : joint_names) {
      const auto place = std::find(message.name.begin(), message.name.end(), name);
      if (place == message.name.end()) return;
      positions.push_back(message.position[static_cast<std::size_t>(place - message.name.begin())]);
    }
    writer->add_joints(message.header.stamp, positions);
  }

  const Options options;
  mutable std::mutex mutex;
  std::condition_variable work;
  std::vector<std::string> frames;  ///< by camera
  std::vector<std::optional<CameraModel>> models;
  TfBuffer tf;
  std::vector<std::optional<Timestamp>> last_pose;                 ///< noted, by camera
  std::map<std::string, std::optional<Timestamp>> last_part_pose;  ///< noted, by part
  Timestamp newest_picture;
  std::vector<StreamRestart> restarts;                 ///< by camera
  std::vector<std::optional<Timestamp>> newest_stamp;  ///< of its pictures
  std::string ending;                                  ///< why it ends, once what waits is written
  std::deque<PoseSample> poses;
  std::deque<JointStateMessage> joints;
  std::deque<Waiting> waiting;
  std::size_t waiting_bytes = 0;
  Status counts;
  bool is_stopping = false;
  // The worker's own.
  std::optional<RecordingWriter> writer;
  std::vector<CameraModel> recorded;
  std::vector<std::string> joint_names;
  bool has_told_damage = false;
  std::thread worker;
};

StreamRecorder::StreamRecorder(Options options) : state_(std::make_unique<State>(std::move(options))) {}
StreamRecorder::~StreamRecorder() = default;

void StreamRecorder::on_picture(std::size_t camera, EncodedPicture picture, const Reception& reception) {
  const bool looks_like = looks_whole(picture);
  {
    const std::lock_guard lock(state_->mutex);
    State& state = *state_;
    ++state.counts.pictures_in;
    if (!state.counts.error.empty() || !state.ending.empty()) {
      ++state.counts.unwritten;
      return;
    }
    if (!state.follows(camera, picture, looks_like, reception)) return;
    if (state.options.cameras.at(camera).frame.empty()) state.frames[camera] = header_of(picture).frame;
    state.newest_picture = std::max(state.newest_picture, header_of(picture).stamp);
    state.waiting_bytes += bytes_of(picture);
    state.waiting.push_back({camera, std::move(picture), reception.steady});
    while (state.waiting_bytes > state.options.waiting_bytes) {
      state.waiting_bytes -= bytes_of(state.waiting.front().picture);
      state.waiting.pop_front();
      ++state.counts.overflowed;
    }
    state.note_poses();
  }
  state_->work.notify_one();
}

void StreamRecorder::on_camera_info(std::size_t camera, const CameraInfoMessage& info) {
  try {
    const CameraModel model = camera_from_info(info, state_->options.cameras.at(camera).name + ", camera_info");
    const std::lock_guard lock(state_->mutex);
    if (!state_->models[camera]) state_->models[camera] = model;
  } catch (const InputError& error) {
    spdlog::debug("{}", error.what());
  }
}

void StreamRecorder::on_transforms(const TransformMessage& message, bool is_static) {
  {
    const std::lock_guard lock(state_->mutex);
    for (const TransformMessage::Transform& transform : message.transforms) {
      state_->tf.add(transform.header.frame, transform.child_frame, transform.header.stamp, transform.parent_from_child,
                     is_static);
      // One after the other: of two steps in one message none is passed over.
      state_->note_poses();
    }
  }
  state_->work.notify_one();
}

void StreamRecorder::on_pose(std::size_t camera, const PoseMessage& pose) {
  const std::lock_guard lock(state_->mutex);
  const std::string& frame = pose.header.frame;
  state_->tf.add(frame.empty() ? state_->options.world_frame : frame, state_->camera_frame(camera), pose.header.stamp,
                 pose.pose);
  state_->note_poses();
}

void StreamRecorder::on_joints(const JointStateMessage& joints) {
  const std::lock_guard lock(state_->mutex);
  if (state_->joints.size() < kMostWaiting) state_->joints.push_back(joints);
}

StreamRecorder::Status StreamRecorder::status() const {
  const std::lock_guard lock(state_->mutex);
  Status status = state_->counts;
  status.waiting_for = state_->waiting_for();
  return status;
}

void StreamRecorder::finish() {
  state_->stop();
}

}  // namespace foreview
