#include "foreview/server/live_source.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/latency_window.h"
#include "foreview/server/mailbox.h"
#include "foreview/server/stream_restart.h"
#include "foreview/server/tf_buffer.h"
#include "foreview/server/thread_priority.h"

namespace foreview {
namespace {

constexpr std::size_t kStampsRemembered = 64;  // per camera, to know duplicates by

struct NewerCapture {
  bool operator()(const IncomingFrame& a, const IncomingFrame& b) const {
    return std::pair(a.generation, a.frame.state.stamp) >= std::pair(b.generation, b.frame.state.stamp);
  }
};

Timestamp wall_now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count()};
}

/// A picture on its way to being decoded.
struct Waiting {
  EncodedPicture picture;
  Timestamp stamp;
  Timestamp arrived;  ///< steady: its last packet
  Timestamp due;      ///< steady: the same after the simulated link
  std::uint64_t publisher = 0;
  std::size_t index = 0;
};

/// One camera's stream.
struct CameraStream {
  std::optional<CameraModel> model;
  std::string frame;  ///< optical frame, once known
  std::deque<Waiting> waiting;
  Mailbox<IncomingFrame, NewerCapture> offered;
  StreamRestart restart;
  std::deque<Timestamp> stamps;  ///< of the last pictures
  std::size_t next_index = 0;
  PictureCounts counts;  ///< but `used`, and what the mailbox counts
  std::string bad_info;  ///< what was last said against its camera_info
  bool has_told_damage = false;
};

}  // namespace

struct LiveSource::State {
  explicit State(Options options_in) : options(std::move(options_in)), link(options.link), clock(options.clock) {
    if (options.cameras.empty()) throw InputError("live source", "has no camera; expected at least one");
    if (options.operator_camera >= options.cameras.size()) {
      throw InputError("live source", "has no camera " + std::to_string(options.operator_camera));
    }
    for (const LiveSource::Camera& camera : options.cameras) {
      streams.push_back(std::make_unique<CameraStream>());
      streams.back()->frame = camera.frame;
    }
    taken.resize(streams.size());
    worker = std::thread([this] { work_until_stopped(); });
  }

  ~State() {
    {
      const std::lock_guard lock(mutex);
      is_stopping = true;
    }
    work.notify_all();
    worker.join();
  }

  [[nodiscard]] std::string pose_frame(std::size_t camera) const { return "pose of camera " + std::to_string(camera); }

  // With `mutex` held.

  void arrive(std::size_t camera, EncodedPicture picture, bool is_picture, const Reception& reception) {
    CameraStream& stream = *streams.at(camera);
    const Timestamp stamp = header_of(picture).stamp;
    wall_from_steady = reception.wall - reception.steady;
    heard = steady_now();
    // What is no picture says nothing of the stream either: its stamp may be anything.
    if (!is_picture) {
      ++stream.counts.in;
      note_damage(stream, options.cameras[camera].name + ": is no picture");
      return;
    }
    StreamRestart::Verdict verdict = stream.restart.note(stamp, reception.publisher, reception.steady);
    if (verdict == StreamRestart::Verdict::begins_anew) {
      begin_generation();
      verdict = stream.restart.note(stamp, reception.publisher, reception.steady);
    }
    if (std::find(stream.stamps.begin(), stream.stamps.end(), stamp) != stream.stamps.end()) {
      ++stream.counts.duplicated;
      return;
    }
    if (verdict == StreamRestart::Verdict::straggles) {
      ++stream.counts.in;
      ++stream.counts.overwritten;
      return;
    }
    stream.stamps.push_back(stamp);
    if (stream.stamps.size() > kStampsRemembered) stream.stamps.pop_front();
    if (reception.publisher == stream.restart.publisher()) {
      clock.observe(stamp, is_synchronised() ? reception.wall : reception.steady);
      transport.add(remote_at(reception.steady) - stamp);
    }
    const std::optional<Timestamp> due = link.send(reception.steady, bytes_of(picture));
    if (!due) {
      ++stream.counts.lost;
      return;
    }
    if (options.cameras[camera].frame.empty()) stream.frame = header_of(picture).frame;
    waiting_bytes += bytes_of(picture);
    stream.waiting.push_back(
        {std::move(picture), stamp, reception.steady, *due, reception.publisher, stream.next_index++});
    ++stream.counts.in;
    while (stream.waiting.size() > options.most_waiting)
      drop(stream, oldest_of_fullest(stream), stream.counts.overwritten);
    while (waiting_bytes > options.waiting_bytes) {
      const auto fullest = std::max_element(streams.begin(), streams.end(), [](const auto& a, const auto& b) {
        return a->waiting.size() < b->waiting.size();
      });
      drop(**fullest, oldest_of_fullest(**fullest), (*fullest)->counts.overwritten);
    }
  }

  /// Of the publisher with most pictures waiting: who floods a topic displaces nobody else's.
  [[nodiscard]] static std::size_t oldest_of_fullest(const CameraStream& stream) {
    std::map<std::uint64_t, std::pair<std::size_t, std::size_t>> publishers;  // pictures, place of the oldest
    for (std::size_t i = 0; i < stream.waiting.size(); ++i) {
      ++publishers.try_emplace(stream.waiting[i].publisher, 0, i).first->second.first;
    }
    const auto fullest = std::max_element(publishers.begin(), publishers.end(),
                                          [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
    return fullest->second.second;
  }

  void note_damage(CameraStream& stream, const std::string& damage) {
    ++stream.counts.damaged;
    spdlog::log(stream.has_told_damage ? spdlog::level::debug : spdlog::level::warn, "picture dropped: {}", damage);
    stream.has_told_damage = true;
  }

  [[nodiscard]] bool is_publisher(std::size_t camera, std::uint64_t publisher) const {
    const std::lock_guard lock(mutex);
    return streams.at(camera)->restart.publisher() == publisher;
  }

  void drop(CameraStream& stream, std::size_t place, std::size_t& count) {
    waiting_bytes -= bytes_of(stream.waiting[place].picture);
    stream.waiting.erase(stream.waiting.begin() + static_cast<std::ptrdiff_t>(place));
    ++count;
  }

  void begin_generation() {
    ++generation;
    spdlog::info("the stream begins anew");
    for (const auto& stream : streams) {
      while (!stream->waiting.empty()) drop(*stream, 0, stream->counts.overwritten);
      stream->stamps.clear();
      stream->restart = StreamRestart();
    }
    tf.clear_moving();
    clock = ClockEstimate(options.clock);
    transport = LatencyWindow();
    newest_capture.reset();
    last_received.reset();
  }

  [[nodiscard]] Timestamp remote_at(Timestamp steady) const {
    if (is_synchronised()) return steady + wall_from_steady;
    return clock.sender_time(steady).value_or(steady + wall_from_steady);
  }

  [[nodiscard]] bool is_synchronised() const { return options.clock.mode == ClockMode::synchronised; }

  [[nodiscard]] std::string camera_frame(std::size_t camera) const {
    return options.cameras[camera].has_pose_topic ? pose_frame(camera) : streams[camera]->frame;
  }

  /// Frames that parts follow: those heard of, and those waited for. Empty: stays where the model has it.
  [[nodiscard]] std::string part_frame(const std::string& part) const {
    if (tf.has(part)) return part;
    const auto& required = options.required_parts;
    return std::find(required.begin(), required.end(), part) != required.end() ? part : std::string();
  }

  [[nodiscard]] std::optional<CaptureState> state_at(std::size_t camera, Timestamp time) const {
    const std::optional<Pose> pose = tf.at(options.world_frame, camera_frame(camera), time);
    if (!pose) return std::nullopt;
    CaptureState state{time, *pose, {}};
    for (const std::string& part : options.parts) {
      const std::string frame = part_frame(part);
      const std::optional<Pose> part_pose = frame.empty() ? Pose() : tf.at(options.world_frame, frame, time);
      if (!part_pose) return std::nullopt;
      state.world_from_part.push_back(*part_pose);
    }
    return state;
  }

  /// The newest time up to `t` at which all is known.
  [[nodiscard]] std::optional<Timestamp> newest_known(Timestamp t) const {
    std::optional<Timestamp> newest = tf.newest(options.world_frame, camera_frame(options.operator_camera), t);
    for (const std::string& part : options.parts) {
      const std::string frame = part_frame(part);
      if (frame.empty() || !newest) continue;
      const std::optional<Timestamp> of_part = tf.newest(options.world_frame, frame, t);
      newest = of_part ? std::optional(std::min(*newest, *of_part)) : std::nullopt;
    }
    if (!newest) return std::nullopt;
    return std::min(*newest, t);
  }

  struct Task {
    std::size_t camera = 0;
    Waiting waiting;
    CameraModel model;
    CaptureState state;
    std::uint64_t generation = 0;
  };

  /// The newest picture that can be decoded now, of the camera whose turn it is. What has waited too long for its state
  /// is dropped. `next`: when to look again.
  std::optional<Task> next_task(Timestamp now, Timestamp& next) {
    for (std::size_t turn = 0; turn < streams.size(); ++turn) {
      const std::size_t camera = (first_turn + turn) % streams.size();
      CameraStream& stream = *streams[camera];
      std::optional<std::size_t> best;
      std::optional<CaptureState> state;
      for (std::size_t i = stream.waiting.size(); i-- > 0;) {
        const Waiting& candidate = stream.waiting[i];
        if (candidate.due > now) {
          next = std::min(next, candidate.due);
          continue;
        }
        if (best && stream.waiting[*best].stamp > candidate.stamp) continue;
        if (auto known = stream.model ? state_at(camera, candidate.stamp) : std::nullopt) {
          best = i;
          state = std::move(known);
        } else {
          next = std::min(next, candidate.due + options.state_wait);
        }
      }
      if (best) {
        Task task{camera, std::move(stream.waiting[*best]), *stream.model, std::move(*state), generation};
        waiting_bytes -= bytes_of(task.waiting.picture);
        stream.waiting.erase(stream.waiting.begin() + static_cast<std::ptrdiff_t>(*best));
        first_turn = camera + 1;
        return task;
      }
      for (std::size_t i = stream.waiting.size(); i-- > 0;) {
        const Waiting& other = stream.waiting[i];
        if (other.due <= now && now - other.due >= options.state_wait) {
          note_stateless(camera, other);
          drop(stream, i, stream.counts.stateless);
        }
      }
    }
    return std::nullopt;
  }

  void note_stateless(std::size_t camera, const Waiting& waiting) {
    const auto level = has_told_stateless ? spdlog::level::debug : spdlog::level::warn;
    has_told_stateless = true;
    const std::string& name = options.cameras[camera].name;
    if (!streams[camera]->model) {
      spdlog::log(level, "{}: picture dropped: no camera_info heard that can be used", name);
    } else {
      spdlog::log(level, "{}: picture dropped: pose of {} in {}, or of a part, not known at {}", name,
                  in_quotes(camera_frame(camera)), in_quotes(options.world_frame), waiting.stamp.to_string());
    }
  }

  void work_until_stopped() {
    lower_thread_priority();
    std::unique_lock lock(mutex);
    while (!is_stopping) {
      const Timestamp now = steady_now();
      Timestamp next = now + Duration{1'000'000'000};
      std::optional<Task> task = next_task(now, next);
      if (!task) {
        work.wait_for(lock, std::chrono::nanoseconds((next - now).nanoseconds));
        continue;
      }
      is_in_work = true;
      lock.unlock();
      cv::Mat picture;
      std::string damage;
      const Timestamp begun = steady_now();
      try {
        picture = decode(task->waiting.picture, options.cameras[task->camera].name,
                         cv::Size(task->model.width, task->model.height));
      } catch (const std::exception& error) {  // InputError, or no memory
        damage = error.what();
      }
      const Timestamp done = steady_now();
      lock.lock();
      CameraStream& stream = *streams[task->camera];
      if (picture.empty()) {
        is_in_work = false;
        note_damage(stream, damage);
        continue;
      }
      if (task->generation != generation) {
        is_in_work = false;
        ++stream.counts.overwritten;
        continue;
      }
      const Waiting& waiting = task->waiting;
      // Only now: had it been damaged, one that is older would have been the newest.
      for (std::size_t i = stream.waiting.size(); i-- > 0;) {
        const Waiting& other = stream.waiting[i];
        if (other.due <= now && other.stamp < waiting.stamp) drop(stream, i, stream.counts.overwritten);
      }
      const Timestamp received = remote_at(waiting.due);
      newest_capture = std::max(newest_capture.value_or(waiting.stamp), waiting.stamp);
      last_received = received;
      available.add(done - waiting.due);
      decoding.add(done - begun);
      time_available = time_available + (done - waiting.due);
      time_decoding = time_decoding + (done - begun);
      IncomingFrame frame{{std::move(picture), std::move(task->model), std::move(task->state)},
                          task->camera,
                          waiting.index,
                          received,
                          generation,
                          false};
      // Without the lock: giving back the memory of the picture that is displaced takes milliseconds.
      lock.unlock();
      stream.offered.put(std::move(frame));
      lock.lock();
      is_in_work = false;
    }
  }

  const Options options;
  mutable std::mutex mutex;
  std::condition_variable work;
  std::vector<std::unique_ptr<CameraStream>> streams;
  TfBuffer tf;
  SimulatedLink link;
  ClockEstimate clock;
  Duration wall_from_steady = wall_now() - steady_now();
  std::optional<Timestamp> heard;  ///< steady
  std::optional<Timestamp> newest_capture, last_received;
  std::atomic<std::uint64_t> generation{0};
  std::size_t waiting_bytes = 0, first_turn = 0;
  LatencyWindow available, decoding, transport;
  Duration time_available, time_decoding;
  bool has_told_stateless = false, is_in_work = false, is_stopping = false;
  std::thread worker;

  // Of the reader, under a lock of its own: it must not wait for the others.
  std::mutex taking;
  std::size_t next_camera = 0;
  struct Taken {
    std::size_t used = 0, voided = 0;
  };
  std::vector<Taken> taken;
};

LiveSource::LiveSource(Options options) : state_(std::make_unique<State>(std::move(options))) {}
LiveSource::~LiveSource() = default;

void LiveSource::on_picture(std::size_t camera, EncodedPicture picture, const Reception& reception) {
  bool is_picture = looks_like_picture(picture);
  // Whoever has not yet shown to be the stream's publisher is looked at more closely: by him it may begin anew.
  if (is_picture && !state_->is_publisher(camera, reception.publisher)) is_picture = looks_whole(picture);
  {
    const std::lock_guard lock(state_->mutex);
    state_->arrive(camera, std::move(picture), is_picture, reception);
  }
  state_->work.notify_one();
}

void LiveSource::on_camera_info(std::size_t camera, const CameraInfoMessage& info) {
  std::optional<CameraModel> model;
  std::string error;
  try {
    model = camera_from_info(info, state_->options.cameras.at(camera).name + ", camera_info");
    model->name = state_->options.cameras[camera].name;
  } catch (const InputError& failure) {
    error = failure.what();
  }
  {
    const std::lock_guard lock(state_->mutex);
    CameraStream& stream = *state_->streams[camera];
    state_->heard = steady_now();
    if (model) stream.model = std::move(model);
    if (!error.empty() && error != stream.bad_info) spdlog::warn("{}", error);
    stream.bad_info = error;
  }
  state_->work.notify_one();
}

void LiveSource::on_transforms(const TransformMessage& message, bool is_static) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->heard = steady_now();
    for (const TransformMessage::Transform& transform : message.transforms) {
      state_->tf.add(transform.header.frame, transform.child_frame, transform.header.stamp, transform.parent_from_child,
                     is_static);
    }
  }
  state_->work.notify_one();
}

void LiveSource::on_pose(std::size_t camera, const PoseMessage& pose) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->heard = steady_now();
    const std::string& frame = pose.header.frame;
    state_->tf.add(frame.empty() ? state_->options.world_frame : frame, state_->pose_frame(camera), pose.header.stamp,
                   pose.pose);
  }
  state_->work.notify_one();
}

std::optional<IncomingFrame> LiveSource::take() {
  const std::lock_guard lock(state_->taking);
  const std::size_t count = state_->streams.size();
  for (std::size_t turn = 0; turn < count; ++turn) {
    const std::size_t camera = (state_->next_camera + turn) % count;
    std::optional<IncomingFrame> frame = state_->streams[camera]->offered.take();
    if (!frame) continue;
    if (frame->generation != state_->generation) {
      ++state_->taken[camera].voided;
      continue;
    }
    state_->next_camera = camera + 1;
    ++state_->taken[camera].used;
    return frame;
  }
  return std::nullopt;
}

std::optional<PredictedState> LiveSource::predicted_state(Timestamp t) const {
  const std::lock_guard lock(state_->mutex);
  const std::optional<Timestamp> known = state_->newest_known(t);
  if (!known) return std::nullopt;
  std::optional<CaptureState> state = state_->state_at(state_->options.operator_camera, *known);
  if (!state) return std::nullopt;
  return PredictedState{state->stamp, state->world_from_camera, std::move(state->world_from_part)};
}

SourceStatus LiveSource::status() {
  SourceStatus status;
  {
    const std::lock_guard lock(state_->mutex);
    status.generation = state_->generation;
    status.newest_capture = state_->newest_capture;
    status.last_received = state_->last_received;
    if (state_->heard) status.last_heard = state_->remote_at(*state_->heard);
    status.is_decoding = state_->is_in_work;
    status.now = state_->remote_at(steady_now());
    status.expected_delay = state_->link.options().delay + state_->transport.quantile(0.5);
    for (const auto& stream : state_->streams) {
      PictureCounts counts = stream->counts;
      counts.overwritten += stream->offered.overwritten();
      status.cameras.push_back(counts);
      status.is_decoding = status.is_decoding || !stream->waiting.empty();
    }
  }
  const std::lock_guard lock(state_->taking);
  for (std::size_t i = 0; i < status.cameras.size(); ++i) {
    PictureCounts& counts = status.cameras[i];
    counts.used = state_->taken[i].used;
    counts.overwritten += state_->taken[i].voided;
    status.pictures_in += counts.in;
    status.used += counts.used;
    status.overwritten += counts.overwritten;
    status.damaged += counts.damaged;
    status.stateless += counts.stateless;
    status.duplicated += counts.duplicated;
    status.lost += counts.lost;
  }
  return status;
}

Timestamp LiveSource::time_at(Timestamp steady) const {
  const std::lock_guard lock(state_->mutex);
  return state_->remote_at(steady);
}

std::uint64_t LiveSource::generation() const {
  return state_->generation;
}

std::size_t LiveSource::cameras() const {
  return state_->streams.size();
}

std::optional<CameraModel> LiveSource::camera_model(std::size_t camera) const {
  const std::lock_guard lock(state_->mutex);
  return state_->streams.at(camera)->model;
}

void LiveSource::set_link(const LinkOptions& options) {
  const std::lock_guard lock(state_->mutex);
  state_->link.set_options(options);
}

LiveSource::Latency LiveSource::latency() const {
  const std::lock_guard lock(state_->mutex);
  Latency latency;
  latency.pictures = state_->available.count();
  latency.median = state_->available.quantile(0.5);
  latency.p99 = state_->available.quantile(0.99);
  latency.decoding_median = state_->decoding.quantile(0.5);
  const double all = state_->time_available.seconds();
  latency.decoding_share = all > 0 ? state_->time_decoding.seconds() / all : 0;
  latency.transport_median = state_->transport.quantile(0.5);
  const Timestamp now = state_->is_synchronised() ? wall_now() : steady_now();
  const ClockEstimate::State clock = state_->clock.state(now);
  latency.drift = clock.drift;
  latency.clock_mode = state_->options.clock.mode;
  latency.clock_uncertainty = clock.uncertainty;
  latency.clock_jumps = clock.jumps;
  latency.clock_warning = clock.warning;
  return latency;
}

}  // namespace foreview
