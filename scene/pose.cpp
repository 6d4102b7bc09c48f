#include "foreview/scene/pose.h"

#include <algorithm>
#include <cmath>

namespace foreview {

Pose Pose::inverse() const {
  const glm::dquat back = glm::conjugate(rotation);
  return {back, back * -translation};
}

glm::dmat4 Pose::matrix() const {
  glm::dmat4 result = glm::mat4_cast(rotation);
  result[3] = glm::dvec4(translation, 1.0);
  return result;
}

Pose operator*(const Pose& a_from_b, const Pose& b_from_c) {
  return {glm::normalize(a_from_b.rotation * b_from_c.rotation),
          a_from_b.rotation * b_from_c.translation + a_from_b.translation};
}

glm::dvec3 operator*(const Pose& a_from_b, const glm::dvec3& point_in_b) {
  return a_from_b.rotation * point_in_b + a_from_b.translation;
}

Pose interpolate(const Pose& from, const Pose& to, double fraction) {
  return {glm::normalize(glm::slerp(from.rotation, to.rotation, fraction)),
          glm::mix(from.translation, to.translation, fraction)};
}

Pose looking_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up) {
  const glm::dvec3 z = glm::normalize(target - eye);
  const glm::dvec3 x = glm::normalize(glm::cross(z, up));
  const glm::dvec3 y = glm::cross(z, x);
  return {glm::normalize(glm::quat_cast(glm::dmat3(x, y, z))), eye};
}

double angle_between(const Pose& a, const Pose& b) {
  const glm::dquat d = glm::conjugate(a.rotation) * b.rotation;
  return 2.0 * std::atan2(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z), std::abs(d.w));
}

}  // namespace foreview
