#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "foreview/calib/landmark.h"
#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"

namespace foreview {

/// How far what is recorded may be off: standard deviations.
struct RegistrationTolerances {
  double rest_translation = 0.01;   ///< metres, of one picture's pose ...
  double rest_rotation = 0.01;      ///< radians
  double mount_translation = 0.03;  ///< ... of what is the same in all of them ...
  double mount_rotation = 0.04;
  double focal_length = 0.03;     ///< ... as a part of it ...
  double principal_point = 0.01;  ///< ... as a part of the focal length
  double pixel = 1.5;             ///< pixels: of a place found in a picture
};

/// What all pictures of a camera have in common.
struct CameraRegistration {
  Pose recorded_from_mounted;     ///< where the camera is, seen from where its poses have it
  double focal_length = 0;        ///< the camera's is exp(this) times the nominal one
  glm::dvec2 principal_point{0};  ///< shift, in nominal focal lengths
  [[nodiscard]] CameraModel camera(const CameraModel& nominal) const;
};

/// translation, rotation (axis times angle) as a rigid motion, and back.
using MotionVector = std::array<double, 6>;
[[nodiscard]] Pose motion_from(const MotionVector& vector);
[[nodiscard]] MotionVector vector_of(const Pose& motion);

/// Where the landmark's anchor sees it: sets its point and camera_from_part. False where it does not meet the surface
/// in front of the camera.
bool place_landmark(Landmark& landmark, const CameraRegistration& common, const CameraModel& camera);

/// Of distances in pixels, the one from which on Tukey's weights are 0: three deviations, as the median tells them, and
/// at least 4.
[[nodiscard]] double tukey_reach(const std::vector<double>& distances);

/// How far observations are from where nominal camera and recorded poses have them, if the landmarks lie where their
/// anchors see them by the record: median, pixels; 0 without observations.
[[nodiscard]] double error_of_record(const CameraModel& nominal, std::span<const Landmark> landmarks);

/// Moves `common` and the rests of `free` keyframes to where the landmarks' observations fit best: the sum of squares
/// of distances in pixels, each in its tolerance, plus of what they are off the record, each in its own; observations
/// far off the others count less or nothing (Tukey's weights). A landmark is where its anchor sees it on the surface,
/// so that the model's geometry decides what is right. Gauss-Newton steps, `steps` of them. Places the landmarks.
/// Returns the median distance that is left, pixels; 0 without observations.
double fit_registration(CameraRegistration& common, const CameraModel& nominal, std::span<Landmark> landmarks,
                        std::span<const std::shared_ptr<Keyframe>> free, const RegistrationTolerances& tolerances,
                        int steps);

}  // namespace foreview
