#pragma once
#include <array>
#include <bitset>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/server/playback_clock.h"
#include "foreview/server/simulated_link.h"
#include "foreview/viewer/key_map.h"
#include "foreview/viewer/operator_camera.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// The mouse over the frame that is shown.
struct FramePointer {
  glm::dvec2 position{0};    ///< pixels of the frame, y down
  glm::dvec2 frame_size{1};  ///< pixels
  bool over_frame = false;   ///< and over no panel
  bool left = false, right = false;
  bool left_pressed = false, right_pressed = false;  ///< went down since the last call, over the frame
  bool shift = false;
  double wheel = 0;  ///< steps, positive away from the operator
};

/// The viewer's state as its user changes it, by keys, mouse and panels. Pure: no window, GL or thread; its time is the
/// playback clock's, which tests simulate.
class ViewerControl {
 public:
  struct Options {
    ViewChoice choice;
    LinkOptions link;
    PipelineKind pipeline = PipelineKind::batched;
    ExtractionOptions extraction;
    std::vector<Timestamp>
        steps;           ///< where step_back and step_forward stop: the operator's camera's pictures, ascending
    CameraModel camera;  ///< the operator's
    CameraSurroundings surroundings;
  };
  /// `clock`: of a recording, or null where nobody can stop time (live). It must outlive this.
  ViewerControl(Options options, PlaybackClock* clock);

  /// What panels show and change in place.
  struct Settings {
    ViewChoice choice;
    LinkOptions link;
    PipelineKind pipeline = PipelineKind::batched;
    ExtractionOptions extraction;
    bool panels = true;
    bool help = false;
    bool probe = false;  ///< look at the polygon under the cursor
    bool full_screen = false;
  };
  [[nodiscard]] Settings& settings() { return settings_; }
  [[nodiscard]] const Settings& settings() const { return settings_; }

  /// What nobody can do with a live stream (pause it) only makes refusal() say so.
  void act(ViewerAction action);
  /// The mouse as it is now; dragging turns and moves the camera, or the split line.
  void point(const FramePointer& pointer);
  /// Keys held down that move the camera.
  void hold(const std::bitset<kMoveKeys>& keys) { held_ = keys; }
  /// Real time has gone on by this much (seconds); `recorded` is where the followed camera is now.
  void advance(double seconds, const Pose& recorded);

  /// Through the camera, so that a change of mode is a movement; the choice follows.
  void set_camera_mode(CameraMode mode);
  [[nodiscard]] OperatorCamera& camera() { return camera_; }
  /// The operator's camera has become another one.
  void set_camera(const CameraModel& camera) { camera_model_ = camera; }
  /// Whether the mouse would take hold of the split line here.
  [[nodiscard]] bool over_split(const FramePointer& pointer) const;
  [[nodiscard]] bool dragging() const { return drag_ != Drag::none; }

  [[nodiscard]] PlaybackClock* clock() const { return clock_; }
  /// Pauses and goes there.
  void scrub(Timestamp time);
  static constexpr std::array kSpeeds{0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0};
  static constexpr const char* kLiveHasNoTime =
      "a live stream cannot be paused, moved in time or slowed down; foreview record keeps it to be replayed";
  static constexpr double kMostDelay = 3;  ///< seconds, for keys and slider

  // Wishes, each once.
  [[nodiscard]] bool take_save_request() { return std::exchange(save_, false); }
  [[nodiscard]] bool take_copy_request() { return std::exchange(copy_, false); }
  [[nodiscard]] bool take_enter_request() { return std::exchange(enter_, false); }
  /// Why the last action was not done; empty: it was, or this was asked already.
  [[nodiscard]] std::string take_refusal() { return std::exchange(refusal_, {}); }
  [[nodiscard]] bool quit() const { return quit_; }

 private:
  [[nodiscard]] static bool needs_clock(ViewerAction action);
  enum class Drag { none, split, turn, look, move };
  void set_mode(ViewMode mode);
  void step(bool forward);
  void change_speed(int direction);
  void change_delay(double seconds);
  void toggle_pause();
  void move_held();
  [[nodiscard]] double radians_per_pixel(const FramePointer& pointer) const;

  Settings settings_;
  std::vector<Timestamp> steps_;
  CameraModel camera_model_;
  OperatorCamera camera_;
  PlaybackClock* clock_;
  std::bitset<kMoveKeys> held_;
  Drag drag_ = Drag::none;
  glm::dvec2 last_position_{0};
  std::string refusal_;
  double held_seconds_ = 0;
  bool save_ = false, copy_ = false, enter_ = false, quit_ = false;
};

/// Panels of a frame, left to right: 2 side by side, else 1.
[[nodiscard]] int view_columns(ViewMode mode);

}  // namespace foreview
