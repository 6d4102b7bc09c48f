#pragma once
#include <string>
#include <vector>

#include "foreview/scene/timestamp.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// The replay window's state: what its keys do and how its time goes on. Pure logic: no clock, no window, no GL.
class ReplayControl {
 public:
  enum class Key { tab, m, h, w, s, space, escape, q, left, right };

  struct Options {
    Timestamp first, last;  ///< of the replay; time begins at `first` and stays at `last`, or begins anew with `loop`
    Duration delay;
    double speed = 1;  ///< recorded seconds per second
    bool loop = false;
    ViewChoice choice;
    std::vector<Timestamp> steps;     ///< where left and right stop: the operator's camera's pictures, ascending
    std::vector<Timestamp> captures;  ///< of all cameras' pictures, ascending, each instant once
  };
  explicit ReplayControl(Options options);

  /// Tab: next mode. M, H, W: the overlays; M also brings the delayed picture up where it is not shown. S: save. Space:
  /// pause, or at the end from the start again. Escape, Q: quit. Left, right: while paused, to the picture before or
  /// after.
  void press(Key key);

  /// Real time has gone on by `elapsed`. Display time follows at `speed`, unless paused, but never by so much that
  /// pictures of more than one instant of capture become due: where extraction cannot keep up, time waits instead of
  /// pictures being skipped.
  void tick(Duration elapsed);

  [[nodiscard]] Timestamp time() const { return time_; }
  [[nodiscard]] const ViewChoice& choice() const { return options_.choice; }
  [[nodiscard]] bool paused() const { return paused_; }
  [[nodiscard]] bool at_end() const { return !options_.loop && time_ >= options_.last; }
  [[nodiscard]] bool quit() const { return quit_; }
  /// Whether S was pressed since the last call.
  [[nodiscard]] bool take_save_request();
  /// Display time per wanted display time, averaged over about the last second; 1: in time.
  [[nodiscard]] double pace() const { return pace_; }

  /// For the window's title: time since `first`, delay, pace and what is special.
  [[nodiscard]] std::string title(const std::string& recording, double frames_per_second) const;

 private:
  [[nodiscard]] Timestamp latest_allowed() const;
  void step(bool forward);

  Options options_;
  Timestamp time_;
  bool paused_ = false, quit_ = false, save_requested_ = false;
  double pace_ = 1;
};

}  // namespace foreview
