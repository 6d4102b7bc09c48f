#include "foreview/server/recording_player.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/server/arrival_schedule.h"
#include "foreview/server/thread_priority.h"

namespace foreview {
namespace {

constexpr std::size_t kHistoryDecoded = 2;
/// Pictures about to arrive that are decoded before history is.
constexpr std::size_t kBeforeHistory = 2;

std::size_t bytes_of(const cv::Mat& picture) {
  return picture.total() * picture.elemSize();
}

}  // namespace

struct RecordingPlayer::State {
  using Picture = std::size_t;  ///< place in `pictures`

  /// What a picture's decoding gave.
  struct Decoded {
    std::optional<CameraFrame> frame;  ///< none: damaged or stateless
    bool is_stateless = false;
    std::string gone;  ///< its file is not there any more
  };
  struct Camera {
    std::optional<Picture> waiting;                   ///< the newest that has arrived and is not decoded
    std::optional<Picture> ready;                     ///< the newest that has arrived and is decoded
    std::uint64_t last_served = 0, last_decoded = 0;  ///< by `turns`; the camera that waited longest goes first
  };

  State(const Recording& recording_in, const PolygonModel& model_in, PlaybackClock& clock_in, const Options& options_in)
      : recording(recording_in),
        model(model_in),
        clock(clock_in),
        options(options_in),
        pictures(pictures_of(recording)),
        schedule(schedule_arrivals(pictures, options.link)),
        cameras(recording.cameras().size()) {
    if (options.camera >= cameras.size()) {
      throw InputError("camera " + std::to_string(options.camera),
                       "is not in the recording; expected 0 to " + std::to_string(cameras.size() - 1));
    }
    begin_generation(clock.now());
    worker = std::thread([this] { decode_until_stopped(); });
  }

  ~State() {
    {
      const std::lock_guard lock(mutex);
      is_stopping = true;
    }
    work.notify_all();
    worker.join();
  }

  // All below, but for what the worker does between its locks, under `mutex`.

  void begin_generation(const PlaybackClock::Moment& moment) {
    counts.generation = moment.generation;
    counts.newest_capture.reset();
    counts.last_received.reset();
    has_arrived.assign(pictures.size(), false);
    for (Camera& camera : cameras) camera.waiting = camera.ready = std::nullopt;
    decoded.clear();
    history.clear();
    next_arrival = next_loss = 0;
    for (; is_due(schedule.losses, next_loss, moment.time); ++next_loss) {
      has_arrived[schedule.losses[next_loss].picture] = true;
    }
    std::vector<ArrivalSchedule::Event> before;
    for (; is_due(schedule.arrivals, next_arrival, moment.time); ++next_arrival) {
      before.push_back(schedule.arrivals[next_arrival]);
      has_arrived[before.back().picture] = true;
    }
    // Pictures are numbered in the order of capture.
    std::sort(before.begin(), before.end(), [](const auto& a, const auto& b) { return a.picture > b.picture; });
    std::vector<std::size_t> of_camera(cameras.size());
    for (const ArrivalSchedule::Event& event : before) {
      std::size_t& count = of_camera[pictures[event.picture].camera];
      if (count == 0) arrive(event.picture, event.time);
      if (count > 0 && count <= options.history) history.push_back(event.picture);
      ++count;
    }
    counts.now = moment.time;
  }

  [[nodiscard]] static bool is_due(const std::vector<ArrivalSchedule::Event>& events, std::size_t next, Timestamp now) {
    return next < events.size() && events[next].time < now;
  }

  void advance() {
    const PlaybackClock::Moment moment = clock.now();
    if (moment.generation != counts.generation) begin_generation(moment);
    for (; is_due(schedule.arrivals, next_arrival, moment.time); ++next_arrival) {
      const ArrivalSchedule::Event& event = schedule.arrivals[next_arrival];
      if (has_arrived[event.picture]) continue;
      has_arrived[event.picture] = true;
      arrive(event.picture, event.time);
    }
    for (; is_due(schedule.losses, next_loss, moment.time); ++next_loss) {
      const Picture picture = schedule.losses[next_loss].picture;
      if (has_arrived[picture]) continue;
      has_arrived[picture] = true;
      ++counts.lost;
      forget(picture);
    }
    counts.now = moment.time;
  }

  void arrive(Picture picture, Timestamp arrival) {
    ++counts.pictures_in;
    const Timestamp capture = pictures[picture].capture;
    counts.newest_capture = std::max(counts.newest_capture.value_or(capture), capture);
    counts.last_received = std::max(counts.last_received.value_or(arrival), arrival);
    received[picture] = arrival;
    if (decoded.count(picture) != 0) {
      make_ready(picture);
    } else if (in_work != picture || in_work_generation != counts.generation) {
      displace(cameras[pictures[picture].camera].waiting, picture);
    }
  }

  /// Of two pictures that arrived the newer one stays.
  void displace(std::optional<Picture>& place, Picture picture) {
    if (place) {
      ++counts.overwritten;
      forget(std::min(*place, picture));
      picture = std::max(*place, picture);
    }
    place = picture;
  }

  void forget(Picture picture) {
    decoded.erase(picture);
    received.erase(picture);
  }

  /// The picture has arrived and is decoded.
  void make_ready(Picture picture) {
    const Decoded& result = decoded.at(picture);
    if (result.frame) {
      displace(cameras[pictures[picture].camera].ready, picture);
      return;
    }
    ++(result.is_stateless ? counts.stateless : counts.damaged);
    forget(picture);
  }

  std::optional<Picture> next_to_decode() {
    const Camera* longest = nullptr;
    for (const Camera& camera : cameras) {
      if (camera.waiting && (longest == nullptr || camera.last_decoded < longest->last_decoded)) longest = &camera;
    }
    if (longest != nullptr) return longest->waiting;
    const std::size_t held = decoded_bytes();
    const bool has_room = decoded.empty() || held + largest_picture() <= options.decoded_bytes;
    if (!has_room) return std::nullopt;
    const auto wants_history = [&] {
      if (history.empty()) return false;
      const std::size_t there = static_cast<std::size_t>(
          std::count_if(history.begin(), history.end(), [&](Picture p) { return decoded.count(p) != 0; }));
      return there < std::min(kHistoryDecoded, history.size());
    };
    std::size_t ahead = 0;
    for (std::size_t i = next_arrival; i < schedule.arrivals.size() && ahead < options.decoded_ahead; ++i) {
      const Picture picture = schedule.arrivals[i].picture;
      if (has_arrived[picture]) continue;
      if (ahead == kBeforeHistory && wants_history()) break;
      ++ahead;
      if (decoded.count(picture) == 0) return picture;
    }
    if (wants_history()) {
      for (const Picture picture : history) {
        if (decoded.count(picture) == 0) return picture;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::size_t decoded_bytes() const {
    std::size_t bytes = 0;
    for (const auto& [picture, result] : decoded) bytes += result.frame ? bytes_of(result.frame->picture) : 0;
    return bytes;
  }

  [[nodiscard]] std::size_t largest_picture() const {
    std::size_t bytes = 0;
    for (const Recording::Camera& camera : recording.cameras()) {
      bytes = std::max(
          bytes, static_cast<std::size_t>(camera.model.width) * static_cast<std::size_t>(camera.model.height) * 3);
    }
    return bytes;
  }

  /// Without the lock: reads only what never changes.
  [[nodiscard]] Decoded decode(Picture picture) const {
    const SentPicture& sent = pictures[picture];
    const Recording::Camera& camera = recording.cameras()[sent.camera];
    Decoded result;
    std::optional<CaptureState> state = recording.capture_state(sent.camera, sent.capture, model);
    if (!state) {
      result.is_stateless = true;
      return result;
    }
    try {
      result.frame = CameraFrame{recording.read_picture(sent.camera, sent.index), camera.model, std::move(*state)};
    } catch (const std::exception& error) {  // InputError, or no memory
      spdlog::debug("{}: picture dropped: {}", recording.name(), error.what());
      std::error_code ignored;
      const std::filesystem::path& file = camera.pictures[sent.index].file;
      if (!std::filesystem::exists(file, ignored)) {
        result.gone =
            recording.directory().string() + ": " +
            (std::filesystem::exists(recording.directory(), ignored) ? "pictures are gone, first " + file.string()
                                                                     : std::string("the recording is gone")) +
            "; expected it to stay while it is played";
      }
    }
    return result;
  }

  void decode_until_stopped() {
    lower_thread_priority();
    std::unique_lock lock(mutex);
    while (!is_stopping) {
      advance();
      const std::optional<Picture> picture = next_to_decode();
      if (!picture) {
        work.wait(lock);
        continue;
      }
      Camera& camera = cameras[pictures[*picture].camera];
      if (camera.waiting == picture) camera.waiting.reset();
      camera.last_decoded = ++turns;
      in_work = picture;
      const std::uint64_t began_in = in_work_generation = counts.generation;
      lock.unlock();
      Decoded result = decode(*picture);
      lock.lock();
      in_work.reset();
      if (!result.gone.empty() && counts.error.empty()) spdlog::warn("{}", result.gone);
      if (result.frame || !result.gone.empty()) counts.error = result.gone;
      if (began_in != counts.generation) continue;
      finish_decoding(*picture, std::move(result));
    }
  }

  void finish_decoding(Picture picture, Decoded result) {
    if (const auto place = std::find(history.begin(), history.end(), picture); place != history.end()) {
      if (!result.frame) {
        history.erase(place);
      } else {
        decoded[picture] = std::move(result);
      }
      return;
    }
    // Lost meanwhile, over another link.
    if (has_arrived[picture] && received.count(picture) == 0) return;
    decoded[picture] = std::move(result);
    if (has_arrived[picture]) make_ready(picture);
  }

  void wake_worker() {
    if (!in_work && next_to_decode()) work.notify_one();
  }

  [[nodiscard]] IncomingFrame hand_over(Picture picture, bool is_history) {
    const SentPicture& sent = pictures[picture];
    const auto arrival = received.find(picture);
    IncomingFrame incoming{std::move(*decoded.at(picture).frame),
                           sent.camera,
                           sent.index,
                           arrival == received.end() ? counts.now : arrival->second,
                           counts.generation,
                           is_history};
    ++(is_history ? counts.history : counts.used);
    forget(picture);
    return incoming;
  }

  std::optional<IncomingFrame> take_new() {
    advance();
    Camera* longest = nullptr;
    for (Camera& camera : cameras) {
      if (camera.ready && (longest == nullptr || camera.last_served < longest->last_served)) longest = &camera;
    }
    if (longest == nullptr) return std::nullopt;
    longest->last_served = ++turns;
    return hand_over(*std::exchange(longest->ready, std::nullopt), false);
  }

  std::optional<IncomingFrame> take_history() {
    if (history.empty() || decoded.count(history.front()) == 0) return std::nullopt;
    const Picture picture = history.front();
    history.pop_front();
    return hand_over(picture, true);
  }

  const Recording& recording;
  const PolygonModel& model;
  PlaybackClock& clock;
  Options options;
  const std::vector<SentPicture> pictures;

  std::mutex mutex;
  std::condition_variable work;  ///< there may be something to decode
  ArrivalSchedule schedule;
  std::size_t next_arrival = 0, next_loss = 0;  ///< in the schedule
  std::vector<bool> has_arrived;  ///< by picture, in this generation: arrived, or lost when it was expected
  std::vector<Camera> cameras;
  std::deque<Picture> history;            ///< newest first
  std::map<Picture, Decoded> decoded;     ///< whether arrived or not
  std::map<Picture, Timestamp> received;  ///< of pictures that have arrived and are still here
  std::optional<Picture> in_work;         ///< being decoded
  std::uint64_t in_work_generation = 0;   ///< the one in which that began
  std::uint64_t turns = 0;
  SourceStatus counts;
  bool is_stopping = false;
  std::thread worker;
};

RecordingPlayer::RecordingPlayer(const Recording& recording, const PolygonModel& model, PlaybackClock& clock,
                                 const Options& options)
    : state_(std::make_unique<State>(recording, model, clock, options)) {}
RecordingPlayer::~RecordingPlayer() = default;

std::optional<IncomingFrame> RecordingPlayer::take() {
  const std::unique_lock lock(state_->mutex, std::try_to_lock);
  if (!lock.owns_lock()) return std::nullopt;
  std::optional<IncomingFrame> frame = state_->take_new();
  if (!frame) frame = state_->take_history();
  state_->wake_worker();
  return frame;
}

std::optional<IncomingFrame> RecordingPlayer::take_new() {
  const std::unique_lock lock(state_->mutex, std::try_to_lock);
  if (!lock.owns_lock()) return std::nullopt;
  std::optional<IncomingFrame> frame = state_->take_new();
  state_->wake_worker();
  return frame;
}

std::optional<PredictedState> RecordingPlayer::predicted_state(Timestamp t) const {
  return state_->recording.predicted_state(state_->options.camera, t, state_->model);
}

SourceStatus RecordingPlayer::status() {
  const std::lock_guard lock(state_->mutex);
  state_->advance();
  state_->wake_worker();
  SourceStatus status = state_->counts;
  status.bytes_decoded = state_->decoded_bytes();
  status.expected_delay = state_->options.link.delay;
  status.is_decoding = state_->in_work || state_->next_to_decode();
  const bool has_more = std::any_of(state_->cameras.begin(), state_->cameras.end(),
                                    [](const auto& camera) { return camera.waiting || camera.ready; });
  status.ended = state_->clock.at_end() && !status.is_decoding && !has_more && state_->history.empty();
  return status;
}

Timestamp RecordingPlayer::time_at(Timestamp steady) const {
  return state_->clock.at(steady).time;
}

std::uint64_t RecordingPlayer::generation() const {
  return state_->clock.now().generation;
}

std::size_t RecordingPlayer::cameras() const {
  return state_->recording.cameras().size();
}

std::optional<CameraModel> RecordingPlayer::camera_model(std::size_t camera) const {
  return state_->recording.cameras().at(camera).model;
}

void RecordingPlayer::set_link(const LinkOptions& options) {
  ArrivalSchedule schedule = schedule_arrivals(state_->pictures, options);
  const std::lock_guard lock(state_->mutex);
  state_->advance();
  state_->options.link = options;
  state_->schedule = std::move(schedule);
  // Those that had arrived stay so.
  state_->next_arrival = state_->next_loss = 0;
  state_->advance();
  state_->wake_worker();
}

LinkOptions RecordingPlayer::link() const {
  const std::lock_guard lock(state_->mutex);
  return state_->options.link;
}

void RecordingPlayer::set_history(std::size_t pictures) {
  const std::lock_guard lock(state_->mutex);
  state_->options.history = pictures;
}

}  // namespace foreview
