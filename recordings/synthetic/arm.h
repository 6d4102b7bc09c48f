#pragma once
#include <array>
#include <vector>

#include "foreview/recordings/synthetic/site_builder.h"
#include "foreview/scene/pose.h"

namespace foreview::synthetic {

/// The workcell's arm: seven revolute joints (shoulder z-y-z, elbow y, wrist z-y-z about each link's own axes) and a
/// gripper whose two fingers slide along x.
namespace arm {

inline constexpr std::size_t kJoints = 7;
inline constexpr double kShoulderHeight = 0.36;  ///< metres above the base
inline constexpr double kUpperArm = 0.42;        ///< shoulder to elbow
inline constexpr double kForearm = 0.40;         ///< elbow to wrist
inline constexpr double kTool = 0.24;            ///< wrist to the point between the finger tips

using JointAngles = std::array<double, kJoints>;  ///< radians

/// Poses of the links 1..7 in the base's frame; the tool lies kTool along link 7's z.
[[nodiscard]] std::array<Pose, kJoints> base_from_links(const JointAngles& joints);
[[nodiscard]] Pose base_from_tool(const JointAngles& joints);
/// Joint angles that bring the tool to a pose: elbow up, turned out of the vertical plane by `elbow_angle` (radians).
/// The pose must be within reach (asserted).
[[nodiscard]] JointAngles joints_for(const Pose& base_from_tool, double elbow_angle);

/// The parts of an arm in a site.
struct Parts {
  std::array<std::uint32_t, kJoints> links{};
  std::uint32_t left_finger = 0, right_finger = 0;
};
/// Builds base (into `fixed_part`, at world_from_base), links and fingers, with their occluders.
[[nodiscard]] Parts build(Site& site, SiteBuilder& builder, std::uint32_t fixed_part, const Pose& world_from_base);

/// Puts the poses of all arm parts into `world_from_part`; `opening` is the way between the finger pads, metres.
void place(const Parts& parts, const Pose& world_from_base, const JointAngles& joints, double opening,
           std::vector<Pose>& world_from_part);

}  // namespace arm
}  // namespace foreview::synthetic
