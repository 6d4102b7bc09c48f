#include "foreview/scene/pose.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace foreview {
namespace {

const Pose kA{glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)), {1, 2, 3}};
const Pose kB{glm::normalize(glm::dquat(0.2, -0.7, 0.1, 0.4)), {-0.5, 0.25, 4}};

TEST(Pose, ComposesLikeItsMatrices) {
  const glm::dvec3 p{0.3, -1.2, 2.5};
  const glm::dvec3 by_pose = (kA * kB) * p;
  const glm::dvec3 by_matrix = glm::dvec3(kA.matrix() * kB.matrix() * glm::dvec4(p, 1));
  EXPECT_LT(glm::length(by_pose - by_matrix), 1e-12);
}

TEST(Pose, InverseUndoesIt) {
  const glm::dvec3 p{0.3, -1.2, 2.5};
  EXPECT_LT(glm::length(kA.inverse() * (kA * p) - p), 1e-12);
}

TEST(Pose, InterpolatesAlongTheShorterArc) {
  const Pose same_rotation_other_sign{-kA.rotation, kA.translation};
  EXPECT_LT(angle_between(interpolate(kA, same_rotation_other_sign, 0.5), kA), 1e-6);
  const Pose quarter = interpolate(kA, kB, 0.25);
  EXPECT_NEAR(angle_between(kA, quarter), 0.25 * angle_between(kA, kB), 1e-9);
}

TEST(Pose, LooksAtItsTargetWithDownInTheLowerPicture) {
  const Pose camera = looking_at({1, 1, 1}, {4, 1, 1}, {0, 0, 1});
  const glm::dvec3 target_in_camera = camera.inverse() * glm::dvec3(4, 1, 1);
  EXPECT_NEAR(target_in_camera.x, 0, 1e-12);
  EXPECT_NEAR(target_in_camera.y, 0, 1e-12);
  EXPECT_NEAR(target_in_camera.z, 3, 1e-12);
  EXPECT_GT((camera.inverse() * glm::dvec3(4, 1, 0)).y, 0);  // below the target is further down the picture: y grows
}

}  // namespace
}  // namespace foreview
