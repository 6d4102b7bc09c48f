#include "foreview/server/capture/v4l2_camera.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <system_error>
#include <utility>

namespace foreview {
namespace {

constexpr std::size_t kErrorsBeforeRestart = 10;
constexpr std::size_t kRestartsInARow = 3;
constexpr Duration kOldestStamp{10'000'000'000};
/// Clocks are read one after the other, and drivers with clocks of their own in the camera extrapolate.
constexpr Duration kStampTolerance{5'000'000};
/// A gap beyond this is a counter that was set, not pictures lost.
constexpr std::uint32_t kLargestGap = 1U << 16;

bool is_gone(int error) {
  return error == -ENODEV || error == -ENXIO;
}

}  // namespace

V4l2Camera::V4l2Camera(Options options, VideoSystem& system) : system_(system), options_(std::move(options)) {
  open();
  mode_ = stream_->format().mode;
  name_ = stream_->name();
}

void V4l2Camera::open() {
  stream_ = std::make_unique<VideoStream>(system_, options_.device, options_.wish, options_.buffers);
  last_activity_ = now();
  errors_in_a_row_ = 0;
  last_driver_sequence_.reset();
  last_driver_stamp_.reset();
  statistics_.is_open = true;
  last_refusal_.clear();
}

bool V4l2Camera::sleep_until(Timestamp moment) {
  const std::int64_t ms = ((moment - now()).nanoseconds + 999'999) / 1'000'000;
  if (ms <= 0) return true;
  return system_.poll(nullptr, 0, static_cast<int>(std::min<std::int64_t>(ms, 3'600'000))) >= 0;
}

bool V4l2Camera::is_streaming() {
  if (stream_) return true;
  if (now() < next_attempt_) return false;
  next_attempt_ = now() + options_.reopen_every;
  try {
    open();
  } catch (const VideoError& error) {
    // Device files appear before their rights do, others look at new devices first, and drivers begin in pieces.
    const bool may_pass = error.code() != 0;
    if (!options_.reopen || !may_pass) throw;
    if (is_gone(-error.code()) || error.code() == ENOENT) {
      if (!is_waiting_for_return_) handle_unplugged();
    } else if (std::exchange(last_refusal_, error.what()) != error.what()) {
      spdlog::warn("{}; trying again", error.what());
    }
    return false;
  }
  const CaptureMode mode = stream_->format().mode;
  if (mode.format != mode_.format || mode.width != mode_.width || mode.height != mode_.height) {
    stream_.reset();
    statistics_.is_open = false;
    throw VideoError(options_.device, "came back with " + mode.to_string() + "; expected " + mode_.to_string(), 0);
  }
  if (std::exchange(is_waiting_for_return_, false)) {
    ++statistics_.reopened;
    spdlog::info("{}: is back", options_.device);
  }
  return true;
}

std::optional<CapturedPicture> V4l2Camera::next(Duration timeout) {
  const Timestamp deadline = now() + timeout;
  while (true) {
    if (!stream_ && !sleep_until(std::min(next_attempt_, deadline))) return std::nullopt;
    if (is_streaming()) {
      Timestamp until = deadline;
      if (options_.stall > Duration{}) until = std::min(until, last_activity_ + options_.stall);
      const VideoStream::Readiness readiness = stream_->wait(until - now());
      if (readiness.was_interrupted) return std::nullopt;
      if (readiness.is_ready || readiness.is_faulty) {
        if (std::optional<CapturedPicture> picture = take_ready()) return picture;
      } else if (options_.stall > Duration{} && now() - last_activity_ >= options_.stall) {
        ++statistics_.stalls;
        restart("gives no pictures for " + std::to_string(options_.stall.seconds()) + " s");
      }
    }
    if (now() >= deadline) return std::nullopt;
  }
}

std::optional<CapturedPicture> V4l2Camera::take_ready() {
  std::optional<CapturedPicture> newest;
  // No more than there can be: a fast camera must not keep this going.
  const std::size_t most = std::max<std::size_t>(stream_->queued(), 1);
  for (std::size_t i = 0; i < most; ++i) {
    v4l2_buffer buffer{};
    const int error = stream_->dequeue(buffer);
    if (error == -EAGAIN && i > 0) break;
    if (error < 0) {
      // A camera that has gone says so again.
      if (!newest || !is_gone(error)) handle_error(error);
      break;
    }
    last_activity_ = now();
    errors_in_a_row_ = 0;
    std::optional<CapturedPicture> picture = read(buffer);
    const int refused = stream_->requeue(buffer);
    if (picture) {
      statistics_.overtaken += newest.has_value();
      newest = std::move(picture);
      restarts_in_a_row_ = 0;
    }
    if (refused < 0) {
      if (!newest || !is_gone(refused)) handle_error(refused);
      break;
    }
    if (newest && !options_.newest_only) break;
  }
  statistics_.delivered += newest.has_value();
  return newest;
}

std::optional<CapturedPicture> V4l2Camera::read(const v4l2_buffer& buffer) {
  count_sequence(buffer.sequence);
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
    ++statistics_.flagged;
    return std::nullopt;
  }
  CapturedPicture picture;
  switch (read_captured(stream_->format(), stream_->bytes_of(buffer), picture.bytes)) {
    case CaptureFault::none:
      break;
    case CaptureFault::short_frame:
      ++statistics_.short_frames;
      return std::nullopt;
    case CaptureFault::wrong_size:
      ++statistics_.wrong_size;
      return std::nullopt;
    case CaptureFault::damaged:
      ++statistics_.damaged;
      return std::nullopt;
  }
  const std::optional<Stamp> stamp = stamp_of(buffer);
  if (!stamp) {
    ++statistics_.bad_stamps;
    return std::nullopt;
  }
  picture.encoding = encoding_of(mode_.format);
  picture.width = mode_.width;
  picture.height = mode_.height;
  picture.stamp = stamp->time + options_.stamp_shift;
  picture.stamp_kind = stamp->kind;
  picture.sequence = *sequence_;
  return picture;
}

void V4l2Camera::count_sequence(std::uint32_t sequence) {
  // Modulo 2^32. Drivers that do not count leave 0 everywhere.
  std::uint32_t step = last_driver_sequence_ ? sequence - *last_driver_sequence_ : 1;
  if (step == 0 || step > kLargestGap) step = 1;
  statistics_.lost += step - 1;
  sequence_ = sequence_ ? *sequence_ + step : step - 1;
  last_driver_sequence_ = sequence;
}

Duration V4l2Camera::wall_from_monotonic() const {
  // Wall time is set and slewed while a camera runs: an offset measured once would grow wrong. Of a few readings the
  // one that was interrupted least counts.
  Duration difference, least{std::numeric_limits<std::int64_t>::max()};
  for (int reading = 0; reading < 3; ++reading) {
    const Timestamp before = system_.now(CLOCK_MONOTONIC);
    const Timestamp wall = system_.now(CLOCK_REALTIME);
    const Duration taken = system_.now(CLOCK_MONOTONIC) - before;
    if (taken >= least) continue;
    least = taken;
    difference = wall - (before + Duration{taken.nanoseconds / 2});
  }
  return difference;
}

std::optional<V4l2Camera::Stamp> V4l2Camera::stamp_of(const v4l2_buffer& buffer) {
  const Duration wall = wall_from_monotonic();
  const Timestamp at = now();
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    if (!options_.stamp_on_arrival) {
      throw VideoError(options_.device,
                       "does not stamp its pictures; expected stamps of the monotonic clock, or to be told to take the "
                       "time of arrival",
                       0);
    }
    return Stamp{at + wall, StampKind::arrival};
  }
  constexpr std::int64_t kMostSeconds = 4'000'000'000;
  const std::int64_t seconds = buffer.timestamp.tv_sec, microseconds = buffer.timestamp.tv_usec;
  if (seconds < 0 || seconds > kMostSeconds || microseconds < 0 || microseconds > 999'999) return std::nullopt;
  const Timestamp stamp{seconds * 1'000'000'000 + microseconds * 1000};
  const Duration age = at - stamp;
  const bool is_possible = stamp > Timestamp{} && age + kStampTolerance > Duration{} && age < kOldestStamp &&
                           (!last_driver_stamp_ || stamp > *last_driver_stamp_);
  if (!is_possible) return std::nullopt;
  last_driver_stamp_ = stamp;
  const bool is_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return Stamp{stamp + wall, is_start ? StampKind::start_of_exposure : StampKind::end_of_frame};
}

void V4l2Camera::handle_error(int error) {
  if (is_gone(error)) return handle_unplugged();
  ++statistics_.io_errors;
  // The driver may have taken a buffer out although it reports an error, and then nobody has it.
  statistics_.buffers_recovered += stream_->requeue_strays();
  if (++errors_in_a_row_ < kErrorsBeforeRestart && stream_->queued() > 0) return;
  restart("cannot be read: " + std::generic_category().message(-error));
}

void V4l2Camera::restart(const std::string& why) {
  stream_.reset();
  statistics_.is_open = false;
  ++statistics_.restarts;
  next_attempt_ = now();
  if (++restarts_in_a_row_ <= kRestartsInARow) return;
  if (!options_.reopen) throw VideoError(options_.device, why + ", again and again; expected pictures", EIO);
  next_attempt_ = now() + options_.reopen_every;
}

void V4l2Camera::handle_unplugged() {
  stream_.reset();
  statistics_.is_open = false;
  ++statistics_.unplugged;
  if (!options_.reopen) {
    throw VideoError(options_.device, "is gone: unplugged, or reset; expected a camera that stays", ENODEV);
  }
  spdlog::warn("{}: is gone; waiting for it to come back", options_.device);
  is_waiting_for_return_ = true;
  next_attempt_ = now() + options_.reopen_every;
}

}  // namespace foreview
