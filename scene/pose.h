#pragma once
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#define GLM_ENABLE_EXPERIMENTAL
#include <glm/gtc/quaternion.hpp>

namespace foreview {

/// A rigid motion. Named target_from_source: `world_from_camera * point_in_camera` is the point in the world, and
/// `a_from_b * b_from_c` is `a_from_c`. Metres; the quaternion is of unit length.
struct Pose {
  glm::dquat rotation{1, 0, 0, 0};  ///< w, x, y, z
  glm::dvec3 translation{0, 0, 0};

  [[nodiscard]] Pose inverse() const;
  [[nodiscard]] glm::dmat4 matrix() const;
  [[nodiscard]] glm::dvec3 rotate(const glm::dvec3& direction) const { return rotation * direction; }
  bool operator==(const Pose&) const = default;
};

[[nodiscard]] Pose operator*(const Pose& a_from_b, const Pose& b_from_c);
[[nodiscard]] glm::dvec3 operator*(const Pose& a_from_b, const glm::dvec3& point_in_b);

/// Between two poses: the position linearly, the rotation along the shorter arc; `fraction` in 0..1.
[[nodiscard]] Pose interpolate(const Pose& from, const Pose& to, double fraction);

/// The pose of a camera at `eye` whose optical axis (z) meets `target`; x stays perpendicular to `up` (so that the
/// picture's bottom is down). `up` must not be parallel to the line of sight.
[[nodiscard]] Pose looking_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up);

/// Angle of the rotation between two poses, radians in 0..pi.
[[nodiscard]] double angle_between(const Pose& a, const Pose& b);

}  // namespace foreview
