#pragma once
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// The time of a replay: what a recording's display time is at a moment of real time. Thread-safe; every member is a
/// computation, none waits.
class PlaybackClock {
 public:
  /// Real time: steady_now(), or a simulated one that never goes back.
  using RealTime = std::function<Timestamp()>;
  struct Options {
    Timestamp first, last;  ///< time begins at `first` and stays at `last`, or begins anew with `loop`
    double speed = 1;       ///< recorded seconds per second, 0.01 to 100
    bool loop = false;
    bool playing = true;
  };
  /// Throws InputError where last < first or the speed is out of range.
  explicit PlaybackClock(Options options, RealTime real_time = {});

  /// A moment of display time. Moments of different generations lie on different sides of a seek, or of the leap back
  /// in a loop.
  struct Moment {
    Timestamp time;
    std::uint64_t generation = 0;
  };
  [[nodiscard]] Moment now() const;
  /// Display time at a moment of real time, now or soon, as playing goes now.
  [[nodiscard]] Moment at(Timestamp real) const;
  /// The real time at which display time will be `time`; none while paused, or where it lies behind or beyond `last`.
  /// In a loop, the next time round is not looked at.
  [[nodiscard]] std::optional<Timestamp> real_time_of(Timestamp time) const;

  /// At the end, plays from the start again.
  void play();
  void pause();
  /// Clamped to first..last. Always a new generation.
  void seek(Timestamp time);
  /// Throws InputError where out of range.
  void set_speed(double speed);
  void set_loop(bool loop);

  [[nodiscard]] bool playing() const;
  [[nodiscard]] bool loop() const;
  [[nodiscard]] double speed() const;
  /// Not looping, and at `last`.
  [[nodiscard]] bool at_end() const;
  [[nodiscard]] Timestamp first() const { return first_; }
  [[nodiscard]] Timestamp last() const { return last_; }

 private:
  [[nodiscard]] Moment at_locked(Timestamp real) const;
  /// Lets time go on from where it is now.
  void anchor_locked();

  const RealTime real_time_;
  const Timestamp first_, last_;
  mutable std::mutex mutex_;
  double speed_;
  bool loop_, playing_;
  Timestamp anchor_real_;  ///< when display time was anchor_
  Moment anchor_;
};

}  // namespace foreview
