#include "foreview/recordings/synthetic/arm.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace foreview::synthetic::arm {
namespace {

const glm::dvec3 kY{0, 1, 0}, kZ{0, 0, 1};

Pose turned(const glm::dvec3& axis, double angle) {
  return {glm::angleAxis(angle, axis), {0, 0, 0}};
}
Pose moved(const glm::dvec3& by) {
  return {glm::dquat(1, 0, 0, 0), by};
}
/// The solid's z axis laid along the part's y: for the drums of the joints that turn about y.
Pose along_y() {
  return {glm::angleAxis(-std::numbers::pi / 2, glm::dvec3(1, 0, 0)), {0, 0, 0}};
}

}  // namespace

std::array<Pose, kJoints> base_from_links(const JointAngles& q) {
  std::array<Pose, kJoints> links;
  links[0] = moved({0, 0, kShoulderHeight}) * turned(kZ, q[0]);
  links[1] = links[0] * turned(kY, q[1]);
  links[2] = links[1] * turned(kZ, q[2]);
  links[3] = links[2] * moved({0, 0, kUpperArm}) * turned(kY, q[3]);
  links[4] = links[3] * turned(kZ, q[4]);
  links[5] = links[4] * moved({0, 0, kForearm}) * turned(kY, q[5]);
  links[6] = links[5] * turned(kZ, q[6]);
  return links;
}

Pose base_from_tool(const JointAngles& joints) {
  return base_from_links(joints)[6] * moved({0, 0, kTool});
}

JointAngles joints_for(const Pose& tool, double elbow_angle) {
  const glm::dvec3 wrist = tool.translation - kTool * tool.rotate(kZ) - glm::dvec3(0, 0, kShoulderHeight);
  const double reach = glm::length(wrist);
  assert(reach < kUpperArm + kForearm && reach > 0.1);
  const glm::dvec3 forward = wrist / reach;
  const double at_shoulder =
      std::acos((kUpperArm * kUpperArm + reach * reach - kForearm * kForearm) / (2 * kUpperArm * reach));
  const glm::dvec3 upward = glm::normalize(kZ - forward * forward.z);
  const glm::dvec3 bend = glm::angleAxis(elbow_angle, forward) * upward;
  const glm::dvec3 upper = std::cos(at_shoulder) * forward + std::sin(at_shoulder) * bend;
  const glm::dvec3 fore = glm::normalize(wrist - kUpperArm * upper);
  JointAngles q{};
  q[0] = std::atan2(upper.y, upper.x);
  q[1] = std::acos(std::clamp(upper.z, -1.0, 1.0));
  const Pose base_from_shoulder = turned(kZ, q[0]) * turned(kY, q[1]);
  const glm::dvec3 fore_in_shoulder = base_from_shoulder.inverse().rotate(fore);
  q[2] = std::atan2(fore_in_shoulder.y, fore_in_shoulder.x);
  q[3] = std::acos(std::clamp(fore_in_shoulder.z, -1.0, 1.0));
  const Pose base_from_elbow = base_from_shoulder * turned(kZ, q[2]) * turned(kY, q[3]);
  const Pose elbow_from_tool = base_from_elbow.inverse() * Pose{tool.rotation, {0, 0, 0}};
  const glm::dvec3 axis = elbow_from_tool.rotate(kZ);
  q[4] = std::atan2(axis.y, axis.x);
  q[5] = std::acos(std::clamp(axis.z, -1.0, 1.0));
  const Pose wrist_from_tool = (turned(kZ, q[4]) * turned(kY, q[5])).inverse() * elbow_from_tool;
  const glm::dvec3 x = wrist_from_tool.rotate({1, 0, 0});
  q[6] = std::atan2(x.y, x.x);
  return q;
}

Parts build(Site& site, SiteBuilder& builder, std::uint32_t fixed_part, const Pose& world_from_base) {
  const std::uint32_t shell =
      builder.surface({Material::label, {0.90F, 0.46F, 0.12F}, {0.12F, 0.14F, 0.18F}, 1, "FV-7"});
  const std::uint32_t plain = builder.surface({Material::paint, {0.88F, 0.47F, 0.14F}, {0, 0, 0}, 2, ""});
  const std::uint32_t drum = builder.surface({Material::metal, {0.42F, 0.44F, 0.48F}, {0.1F, 0.1F, 0.1F}, 3, ""});
  const std::uint32_t cap = builder.surface({Material::marker, {0.92F, 0.90F, 0.85F}, {0.10F, 0.11F, 0.13F}, 4, ""});
  const std::uint32_t stripe = builder.surface({Material::hazard, {0.95F, 0.78F, 0.10F}, {0.08F, 0.08F, 0.08F}, 5, ""});
  const std::uint32_t dark =
      builder.surface({Material::metal, {0.25F, 0.26F, 0.29F}, {0.85F, 0.85F, 0.80F}, 6, "GRIP"});
  constexpr int kSides = 8;

  builder.lathe(fixed_part, world_from_base,
                {{0.13, 0, stripe}, {0.13, 0.04, shell}, {0.095, 0.12, shell}, {0.085, 0.28, shell}}, kSides, drum,
                drum);
  Parts parts;
  const std::array<const char*, kJoints> names{"link1", "link2", "link3", "link4", "link5", "link6", "link7"};
  for (std::size_t i = 0; i < kJoints; ++i) parts.links[i] = builder.part(names[i], true);
  const Pose here;
  builder.prism(parts.links[0], here, 0.088, -0.078, 0.0, kSides, drum, cap);
  builder.prism(parts.links[1], along_y(), 0.078, -0.098, 0.098, kSides, plain, cap);
  builder.lathe(parts.links[2], here, {{0.062, 0.05, drum}, {0.072, 0.10, shell}, {0.060, 0.36, shell}}, kSides, drum,
                drum);
  builder.prism(parts.links[3], along_y(), 0.066, -0.085, 0.085, kSides, plain, cap);
  builder.lathe(parts.links[4], here, {{0.052, 0.05, drum}, {0.058, 0.09, shell}, {0.046, 0.35, shell}}, kSides, drum,
                drum);
  builder.prism(parts.links[5], along_y(), 0.050, -0.062, 0.062, kSides, plain, cap);
  builder.prism(parts.links[6], here, 0.042, 0.035, 0.10, kSides, drum, drum);
  builder.box(parts.links[6], moved({0, 0, 0.125}), {0.15, 0.07, 0.05}, dark);

  parts.left_finger = builder.part("finger_left", true);
  parts.right_finger = builder.part("finger_right", true);
  for (const bool left : {true, false}) {
    const double side = left ? -1 : 1;
    const std::uint32_t part = left ? parts.left_finger : parts.right_finger;
    // The pad's inner face lies in the part's plane x = 0.
    builder.box(part, moved({side * 0.010, 0, 0.185}), {0.020, 0.034, 0.070}, drum);
    builder.box(part, moved({side * 0.008, 0, 0.238}), {0.016, 0.030, 0.036}, stripe);
    site.moving_occluders.push_back({part, {side * 0.01, 0, 0.16}, {side * 0.01, 0, 0.25}, 0.016});
  }
  site.moving_occluders.push_back({parts.links[1], {0, 0, 0}, {0, 0, 0.05}, 0.085});
  site.moving_occluders.push_back({parts.links[2], {0, 0, 0.08}, {0, 0, 0.36}, 0.064});
  site.moving_occluders.push_back({parts.links[3], {0, -0.05, 0}, {0, 0.05, 0}, 0.066});
  site.moving_occluders.push_back({parts.links[4], {0, 0, 0.06}, {0, 0, 0.34}, 0.052});
  site.moving_occluders.push_back({parts.links[5], {0, -0.03, 0}, {0, 0.03, 0}, 0.05});
  site.moving_occluders.push_back({parts.links[6], {-0.05, 0, 0.11}, {0.05, 0, 0.11}, 0.036});
  return parts;
}

void place(const Parts& parts, const Pose& world_from_base, const JointAngles& joints, double opening,
           std::vector<Pose>& world_from_part) {
  const std::array<Pose, kJoints> links = base_from_links(joints);
  for (std::size_t i = 0; i < kJoints; ++i) world_from_part[parts.links[i]] = world_from_base * links[i];
  const Pose hand = world_from_base * links[6];
  world_from_part[parts.left_finger] = hand * moved({-opening / 2, 0, 0});
  world_from_part[parts.right_finger] = hand * moved({opening / 2, 0, 0});
}

}  // namespace foreview::synthetic::arm
