#include "foreview/server/playback_clock.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "foreview/scene/errors.h"
#include "foreview/server/frame_source.h"

namespace foreview {
namespace {

double checked_speed(double speed) {
  if (!(speed >= 0.01 && speed <= 100)) {
    throw InputError("speed", std::to_string(speed) + " is out of range; expected 0.01 to 100");
  }
  return speed;
}

}  // namespace

PlaybackClock::PlaybackClock(Options options, RealTime real_time)
    : real_time_(real_time ? std::move(real_time) : RealTime(steady_now)),
      first_(options.first),
      last_(options.last),
      speed_(checked_speed(options.speed)),
      loop_(options.loop),
      playing_(options.playing),
      anchor_real_(real_time_()),
      anchor_{options.first, 0} {
  if (last_ < first_) throw InputError("playback", "ends before it begins");
}

PlaybackClock::Moment PlaybackClock::at_locked(Timestamp real) const {
  if (!playing_) return anchor_;
  const double elapsed = std::max(0.0, (real - anchor_real_).seconds()) * speed_;
  const Duration left = last_ - anchor_.time;
  if (elapsed < left.seconds()) {
    return {std::min(anchor_.time + Duration::from_seconds(elapsed), last_), anchor_.generation};
  }
  const double length = (last_ - first_).seconds();
  if (!loop_ || length <= 0) return {last_, anchor_.generation};
  const double beyond = elapsed - left.seconds();
  const double rounds = std::floor(beyond / length);
  return {std::min(first_ + Duration::from_seconds(beyond - rounds * length), last_),
          anchor_.generation + 1 + static_cast<std::uint64_t>(rounds)};
}

void PlaybackClock::anchor_locked() {
  const Timestamp real = real_time_();
  anchor_ = at_locked(real);
  anchor_real_ = real;
}

PlaybackClock::Moment PlaybackClock::now() const {
  const std::lock_guard lock(mutex_);
  return at_locked(real_time_());
}

PlaybackClock::Moment PlaybackClock::at(Timestamp real) const {
  const std::lock_guard lock(mutex_);
  return at_locked(real);
}

std::optional<Timestamp> PlaybackClock::real_time_of(Timestamp time) const {
  const std::lock_guard lock(mutex_);
  const Timestamp real = real_time_();
  const Timestamp now = at_locked(real).time;
  if (!playing_ || time < now || time > last_) return std::nullopt;
  return real + Duration::from_seconds((time - now).seconds() / speed_);
}

void PlaybackClock::play() {
  const std::lock_guard lock(mutex_);
  anchor_locked();
  if (!loop_ && anchor_.time >= last_) anchor_ = {first_, anchor_.generation + 1};
  playing_ = true;
}

void PlaybackClock::pause() {
  const std::lock_guard lock(mutex_);
  anchor_locked();
  playing_ = false;
}

void PlaybackClock::seek(Timestamp time) {
  const std::lock_guard lock(mutex_);
  anchor_locked();
  anchor_ = {std::clamp(time, first_, last_), anchor_.generation + 1};
}

void PlaybackClock::set_speed(double speed) {
  const double checked = checked_speed(speed);
  const std::lock_guard lock(mutex_);
  anchor_locked();
  speed_ = checked;
}

void PlaybackClock::set_loop(bool loop) {
  const std::lock_guard lock(mutex_);
  anchor_locked();
  loop_ = loop;
}

bool PlaybackClock::playing() const {
  const std::lock_guard lock(mutex_);
  return playing_;
}

bool PlaybackClock::loop() const {
  const std::lock_guard lock(mutex_);
  return loop_;
}

double PlaybackClock::speed() const {
  const std::lock_guard lock(mutex_);
  return speed_;
}

bool PlaybackClock::at_end() const {
  const std::lock_guard lock(mutex_);
  return !loop_ && at_locked(real_time_()).time >= last_;
}

}  // namespace foreview
