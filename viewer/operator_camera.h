#pragma once
#include <glm/vec3.hpp>
#include <optional>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"
#include "foreview/viewer/camera_surroundings.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// The same camera with another field of view, from the picture's top to its bottom (radians, kLeastFieldOfView ..
/// kGreatestFieldOfView; none: as it is). Without distortion.
[[nodiscard]] CameraModel with_field_of_view(const CameraModel& camera, std::optional<double> radians);
/// Radians from the picture's top to its bottom.
[[nodiscard]] double field_of_view(const CameraModel& camera);

/// How a camera moves: world frame.
struct CameraMotion {
  glm::dvec3 velocity{0};          ///< metres per second
  glm::dvec3 angular_velocity{0};  ///< radians per second about the world's axes
};

/// The operator's virtual camera P_d: follows the recorded (or commanded) camera, looks around from it, flies freely,
/// or gives an overview. Pure: no clock, window or GL.
///
/// Inputs are amounts (of mouse or keys), taken up over about kSmoothing, so that single steps of a wheel or a slow
/// mouse do not show. What a camera has done after a time does not depend on how often advance() was called. No input
/// but roll() and level() changes how much the camera leans to the side (the elevation of its x axis), and none turns
/// it over the vertical. A change of mode begins at the present pose.
class OperatorCamera {
 public:
  static constexpr double kSmoothing = 0.06;   ///< seconds
  static constexpr double kTransition = 0.45;  ///< seconds that a change of mode takes

  explicit OperatorCamera(const CameraSurroundings& surroundings = {});
  /// May change at any time; moves nothing by itself.
  void set_surroundings(const CameraSurroundings& surroundings) { surroundings_ = surroundings; }
  [[nodiscard]] const CameraSurroundings& surroundings() const { return surroundings_; }

  [[nodiscard]] CameraMode mode() const { return mode_; }
  /// From the present pose. To the mode that it is in already: back to where that mode begins.
  void set_mode(CameraMode mode);

  /// Time goes on by this much (seconds, >= 0); `recorded` is where the followed camera is at the new moment.
  void advance(double seconds, const Pose& recorded);
  /// world_from_camera at the moment last advanced to.
  [[nodiscard]] Pose pose() const;
  /// The pose `seconds` later, if no input comes and the followed camera is at `recorded` then: for the moment that a
  /// frame will be seen. Smooth motions go on and come to rest as they would; nothing overshoots.
  [[nodiscard]] Pose pose_ahead(double seconds, const Pose& recorded) const;
  /// How the camera moves now, the followed camera taken to stand still.
  [[nodiscard]] CameraMotion motion() const;
  /// Whether it is still moving of itself: a next frame would look different.
  [[nodiscard]] bool is_moving() const;

  // Input. Angles in radians, right and down positive, as a mouse moves. In follow mode nothing but look() and orbit()
  // do anything, and those begin to look around. In look_around they turn; in overview all act as in free mode.

  /// Around the pivot.
  void orbit(double right, double down);
  /// On the spot.
  void look(double right, double down);
  /// The scene at the pivot's distance goes along by this many metres.
  void pan(double right, double down);
  /// Distance to the pivot times this (> 0); the pivot stays.
  void dolly(double factor);
  /// Until called again: moves with this velocity in the camera's own frame (x right, y down, z forward; metres per
  /// second). The pivot is carried along.
  void fly(const glm::dvec3& velocity);
  /// About the line of sight, clockwise as the operator leans.
  void roll(double angle);
  /// Rolls upright.
  void level();
  /// A point that the operator picked: what orbit() turns around. The pose does not change.
  void set_pivot(const glm::dvec3& point_in_world);
  [[nodiscard]] glm::dvec3 pivot() const;

  /// Metres that pan() needs for the pivot's surroundings to follow the mouse by one pixel.
  [[nodiscard]] double metres_per_pixel(const CameraModel& camera) const;

  /// Mode, pose and turn of a choice, at once, without transition; `recorded` as in advance().
  void apply(const ViewChoice& choice, const CameraModel& camera, const Pose& recorded);
  /// Into a choice, so that apply() brings this view back.
  void store(ViewChoice& choice) const;
  /// Where an overview begins: beyond `recorded` backwards and upwards, so that scene and camera are in it.
  [[nodiscard]] Pose overview_pose(const Pose& recorded, double field_of_view) const;
  /// For overview_pose(): radians from top to bottom.
  void set_field_of_view(double radians) { field_of_view_ = radians; }

 private:
  void place(const Pose& pose);
  void take_up(double seconds);
  [[nodiscard]] Pose mode_pose() const;

  CameraSurroundings surroundings_;
  CameraMode mode_ = CameraMode::follow;
  double field_of_view_ = 0.8;
  Pose recorded_;
  // Free and overview: rotation, and the pivot in the world and as the camera sees it. Turns about `up` are applied
  // from the left and those about the camera's x axis from the right, so that they commute and never roll.
  glm::dquat rotation_{1, 0, 0, 0};
  glm::dvec3 pivot_{0}, pivot_in_camera_{0, 0, 1};
  glm::dvec2 turn_{0};  ///< look_around
  // What is still to be taken up.
  glm::dvec2 orbit_left_{0}, look_left_{0}, pan_left_{0};
  double dolly_left_ = 0;  ///< logarithm of the factor
  double roll_left_ = 0;
  glm::dvec3 velocity_{0}, wanted_velocity_{0};  ///< camera frame
  // Since a change of mode.
  Pose transition_offset_;      ///< mode's pose to what was shown, so that a followed camera is not lagged behind
  double transition_left_ = 0;  ///< seconds
};

}  // namespace foreview
