#include "foreview/viewer/registered_source.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "foreview/server/mailbox.h"
#include "foreview/server/thread_priority.h"

namespace foreview {
namespace {

/// As often as a display asks.
constexpr std::chrono::milliseconds kAskAgain{1};

struct Registered {
  IncomingFrame incoming;
  Pose registered_from_recorded;
  RegistrationStatus status;
};

struct NewerCapture {
  bool operator()(const Registered& a, const Registered& b) const {
    return std::pair(a.incoming.generation, a.incoming.frame.state.stamp) >=
           std::pair(b.incoming.generation, b.incoming.frame.state.stamp);
  }
};

}  // namespace

struct RegisteredSource::State {
  State(FrameSource& of_source, const PolygonModel& of_model, std::size_t operator_camera)
      : source(of_source),
        model(of_model),
        camera(operator_camera),
        offered(source.cameras()),
        taken(source.cameras()),
        worker([this] { work_until_stopped(); }) {}

  ~State() {
    {
      const std::lock_guard lock(mutex);
      is_stopping = true;
    }
    stopping.notify_all();
    worker.join();
  }

  // The worker.

  void work_until_stopped() {
    lower_thread_priority();
    const RayCaster rays(model);
    std::vector<Registration> registrations(offered.size(), Registration(model, rays));
    std::uint64_t generation = source.generation();
    while (!is_stopping) {
      // Were it asked for history, too, a new picture would have to wait until the one that is here is taken.
      std::optional<IncomingFrame> incoming = history.has_unread() ? source.take_new() : source.take();
      if (!incoming) {
        std::unique_lock lock(mutex);
        stopping.wait_for(lock, kAskAgain, [this] { return is_stopping.load(); });
        continue;
      }
      if (std::exchange(generation, incoming->generation) != generation) {
        for (Registration& registration : registrations) registration.leap();
      }
      correct(std::move(*incoming), registrations[incoming->camera]);
    }
  }

  void correct(IncomingFrame incoming, Registration& registration) {
    picture_bytes = incoming.frame.picture.total() * incoming.frame.picture.elemSize();
    const CameraModel camera_given = incoming.frame.camera;
    const CaptureState recorded = incoming.frame.state;
    Registered registered{std::move(incoming), {}, {}};
    try {
      registration.place(registered.incoming.frame);
      registered.registered_from_recorded = registration.registered_from_recorded();
      registered.status = registration.status();
    } catch (const std::exception& error) {  // no memory, or a picture that is none: extraction says so
      note(error);
      registered.incoming.frame.camera = camera_given;
      registered.incoming.frame.state = recorded;
    }
    Offered& box = registered.incoming.is_history ? history : offered[registered.incoming.camera];
    box.put(std::move(registered));
    try {
      registration.learn();
    } catch (const std::exception& error) {
      note(error);
    }
  }

  void note(const std::exception& error) {
    spdlog::log(std::exchange(has_failed, true) ? spdlog::level::debug : spdlog::level::warn,
                "a picture could not be registered: {}", error.what());
  }

  // The reader, with `taking` held, which the worker never holds: nobody waits for a thread of low priority.

  std::optional<IncomingFrame> take_new() {
    const std::uint64_t generation = source.generation();
    for (std::size_t turn = 0; turn < offered.size(); ++turn) {
      const std::size_t of = (next_camera + turn) % offered.size();
      std::optional<Registered> registered = offered[of].take();
      if (!registered) continue;
      if (registered->incoming.generation != generation) {
        ++taken[of].voided;
        continue;
      }
      next_camera = of + 1;
      ++taken[of].used;
      if (of == camera) {
        const CaptureState& state = registered->incoming.frame.state;
        if (!newest || newest->generation != generation || newest->captured <= state.stamp) {
          newest =
              Newest{generation, state.stamp, registered->registered_from_recorded, registered->incoming.frame.camera};
        }
        status = registered->status;
      }
      return std::move(registered->incoming);
    }
    return std::nullopt;
  }

  std::optional<IncomingFrame> take_history() {
    std::optional<Registered> registered = history.take();
    if (!registered) return std::nullopt;
    if (registered->incoming.generation != source.generation()) {
      ++history_voided;
      return std::nullopt;
    }
    ++history_used;
    if (registered->incoming.camera == camera) status = registered->status;
    return std::move(registered->incoming);
  }

  struct Newest {
    std::uint64_t generation = 0;
    Timestamp captured;
    Pose registered_from_recorded;
    CameraModel camera;
  };
  /// None: nothing is known of this generation.
  [[nodiscard]] const std::optional<Newest>& newest_now() const {
    static const std::optional<Newest> kNone;
    return newest && newest->generation == source.generation() ? newest : kNone;
  }

  FrameSource& source;
  const PolygonModel& model;
  const std::size_t camera;
  using Offered = Mailbox<Registered, NewerCapture>;
  std::vector<Offered> offered;  ///< by camera
  Offered history;               ///< one at most: the worker looks before it puts one in
  std::atomic<std::size_t> picture_bytes = 0;
  bool has_failed = false;  ///< of the worker

  mutable std::mutex taking;
  struct Taken {
    std::size_t used = 0, voided = 0;
  };
  std::vector<Taken> taken;  ///< by camera
  std::size_t history_used = 0, history_voided = 0, next_camera = 0;
  std::optional<Newest> newest;
  RegistrationStatus status;  ///< of the operator's camera

  std::mutex mutex;  ///< of `stopping`
  std::condition_variable stopping;
  std::atomic<bool> is_stopping = false;
  std::thread worker;
};

RegisteredSource::RegisteredSource(FrameSource& source, const PolygonModel& model, std::size_t camera)
    : state_(std::make_unique<State>(source, model, camera)) {}
RegisteredSource::~RegisteredSource() = default;

std::optional<IncomingFrame> RegisteredSource::take() {
  const std::lock_guard lock(state_->taking);
  if (std::optional<IncomingFrame> incoming = state_->take_new()) return incoming;
  return state_->take_history();
}

std::optional<IncomingFrame> RegisteredSource::take_new() {
  const std::lock_guard lock(state_->taking);
  return state_->take_new();
}

std::optional<PredictedState> RegisteredSource::predicted_state(Timestamp t) const {
  std::optional<PredictedState> state = state_->source.predicted_state(t);
  const std::lock_guard lock(state_->taking);
  if (const auto& newest = state_->newest_now(); state && newest) {
    state->world_from_camera = newest->registered_from_recorded * state->world_from_camera;
  }
  return state;
}

std::optional<CameraModel> RegisteredSource::registered_camera() const {
  const std::lock_guard lock(state_->taking);
  const auto& newest = state_->newest_now();
  return newest ? std::optional(newest->camera) : std::nullopt;
}

SourceStatus RegisteredSource::status() {
  std::vector<PictureCounts> own(state_->offered.size());
  std::size_t used = 0, overwritten = 0, history = 0, done = 0;
  {
    const std::lock_guard lock(state_->taking);
    for (std::size_t i = 0; i < own.size(); ++i) {
      own[i].used = state_->taken[i].used;
      own[i].overwritten = state_->taken[i].voided + state_->offered[i].overwritten();
      used += own[i].used;
      overwritten += own[i].overwritten;
    }
    history = state_->history_used;
    done = used + overwritten + history + state_->history_voided;
  }
  // Asked after our own counts were read: so what is counted here has come there.
  SourceStatus status = state_->source.status();
  const std::size_t in_work = status.used + status.history - done;
  status.used = used;
  status.overwritten += overwritten;
  status.history = history;
  for (std::size_t i = 0; i < status.cameras.size(); ++i) {
    status.cameras[i].used = own[i].used;
    status.cameras[i].overwritten += own[i].overwritten;
  }
  status.bytes_decoded += in_work * state_->picture_bytes;
  status.is_decoding = status.is_decoding || in_work > 0;
  status.ended = status.ended && in_work == 0;
  return status;
}

Timestamp RegisteredSource::time_at(Timestamp steady) const {
  return state_->source.time_at(steady);
}

bool RegisteredSource::is_live() const {
  return state_->source.is_live();
}

std::uint64_t RegisteredSource::generation() const {
  return state_->source.generation();
}

std::size_t RegisteredSource::cameras() const {
  return state_->source.cameras();
}

std::optional<CameraModel> RegisteredSource::camera_model(std::size_t camera) const {
  return state_->source.camera_model(camera);
}

RegistrationStatus RegisteredSource::registration() const {
  const std::lock_guard lock(state_->taking);
  return state_->status;
}

}  // namespace foreview
