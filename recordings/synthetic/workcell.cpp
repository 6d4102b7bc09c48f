#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>

#include "foreview/recordings/synthetic/arm.h"
#include "foreview/recordings/synthetic/noise.h"
#include "foreview/recordings/synthetic/paths.h"
#include "foreview/recordings/synthetic/site_builder.h"
#include "foreview/recordings/synthetic/workcell_things.h"

namespace foreview::synthetic {
namespace {

constexpr std::size_t kPolygons = 1936;  // spec 12
constexpr double kBenchTop = 0.78;       // metres
const glm::dvec3 kRoom{5.0, 4.5, 2.5};
const Pose kWorldFromArm = placed({2.5, 3.30, kBenchTop});

// The workpiece: where it stands first and last, and how it is held.
const glm::dvec3 kPickPlace{2.02, 2.84, kBenchTop}, kPutPlace{2.96, 2.78, kBenchTop};
constexpr double kGripHeight = 0.095, kWorkpieceRadius = 0.036, kOpen = 0.11;
constexpr double kGrasp = 2.9, kRelease = 7.2;  // seconds: fingers closed from, to

/// A tool pose with the fingers pointing down.
Pose tool_at(const glm::dvec3& position, double yaw) {
  return {glm::angleAxis(yaw, glm::dvec3(0, 0, 1)) * glm::angleAxis(std::numbers::pi, glm::dvec3(1, 0, 0)), position};
}

Pose world_from_tool(double t) {
  const glm::dvec3 up{0, 0, 1};
  const glm::dvec3 pick = kPickPlace + up * kGripHeight, put = kPutPlace + up * kGripHeight;
  static const std::vector<Key<glm::dvec3>> kWay{{0.0, {2.55, 2.70, 1.25}},
                                                 {1.5, pick + up * 0.28},
                                                 {2.4, pick},
                                                 {kGrasp, pick},
                                                 {3.9, pick + up * 0.34},
                                                 {5.2, {2.45, 2.62, 1.30}},
                                                 {6.2, put + up * 0.26},
                                                 {7.0, put},
                                                 {kRelease + 0.4, put},
                                                 {8.4, put + up * 0.30},
                                                 {9.8, {2.20, 2.72, 1.25}},
                                                 {11.2, {2.85, 2.66, 1.12}},
                                                 {12.9, {2.45, 2.66, 1.28}}};
  static const std::vector<Key<double>> kYaw{{0.0, 0.3},  {1.5, 0.9}, {kGrasp, 0.9}, {5.2, -0.4}, {6.2, -0.9},
                                             {8.4, -0.9}, {9.8, 0.7}, {11.2, -0.5},  {12.9, 0.2}};
  return tool_at(stop_and_go(kWay, t), stop_and_go(kYaw, t));
}

double opening(double t) {
  static const std::vector<Key<double>> kKeys{{0.0, 0.06},
                                              {1.2, kOpen},
                                              {2.45, kOpen},
                                              {kGrasp, 2 * kWorkpieceRadius * 0.97},
                                              {kRelease, 2 * kWorkpieceRadius * 0.97},
                                              {kRelease + 0.4, kOpen},
                                              {9.5, 0.05}};
  return stop_and_go(kKeys, t);
}

arm::JointAngles joints(double t) {
  const double elbow = 0.35 * std::sin(0.55 * t + 0.4);
  return arm::joints_for(kWorldFromArm.inverse() * world_from_tool(t), elbow);
}

Pose world_from_workpiece(double t) {
  const Pose before = placed(kPickPlace, 0.25);
  if (t <= kGrasp) return before;
  const Pose tool_from_workpiece = world_from_tool(kGrasp).inverse() * before;
  return world_from_tool(std::min(t, kRelease)) * tool_from_workpiece;
}

/// The head: pan to the left positive, tilt upwards positive, radians; its carriage rolls in front of the bench.
Pose world_from_head(double t) {
  static const std::vector<Key<glm::dvec3>> kWay{
      {-1.0, {3.3, 1.50, 1.50}},  {0.0, {3.00, 1.50, 1.50}},  {1.6, {1.95, 1.76, 1.35}}, {3.2, {2.90, 1.70, 1.58}},
      {4.8, {2.05, 1.74, 1.45}},  {6.4, {2.90, 1.64, 1.38}},  {8.0, {1.90, 1.74, 1.58}}, {9.4, {1.145, 1.76, 1.41}},
      {11.0, {2.40, 1.50, 1.55}}, {12.8, {3.00, 1.58, 1.40}}, {13.8, {3.3, 1.5, 1.4}}};
  static const std::vector<Key<glm::dvec2>> kLook{
      {-1.0, {-0.5, -0.2}},   {0.0, {-0.22, -0.28}}, {0.8, {0.35, -0.42}},  {1.6, {-0.32, -0.34}},
      {2.4, {0.10, -0.46}},   {3.2, {0.36, -0.44}},  {4.0, {-0.20, -0.38}}, {4.8, {-0.55, -0.26}},
      {5.6, {0.15, -0.44}},   {6.4, {0.34, -0.38}},  {7.2, {-0.15, -0.34}}, {8.0, {0.40, -0.44}},
      {8.8, {1.15, -0.12}},   {9.4, {1.57, 0.04}},   {10.0, {1.25, -0.22}}, {11.0, {0.28, -0.46}},
      {11.9, {-0.35, -0.26}}, {12.8, {0.20, -0.36}}, {13.8, {0.4, -0.3}}};
  const glm::dvec3 eye = smooth_through(kWay, t);
  const glm::dvec2 look = smooth_through(kLook, t);
  const glm::dvec3 forward{-std::sin(look.x) * std::cos(look.y), std::cos(look.x) * std::cos(look.y), std::sin(look.y)};
  return looking_at(eye, eye + forward, {0, 0, 1});
}

CameraModel stereo_camera(const std::string& name, bool left) {
  CameraModel camera;
  camera.name = name;
  camera.width = 751;
  camera.height = 570;
  camera.focal_length = left ? glm::dvec2(620.4, 619.1) : glm::dvec2(618.7, 617.6);
  camera.principal_point = left ? glm::dvec2(377.3, 283.6) : glm::dvec2(373.1, 287.2);
  camera.distortion_model = DistortionModel::plumb_bob;
  camera.distortion = {left ? -0.121 : -0.118, left ? 0.031 : 0.028, 0.0006, -0.0004, 0, 0, 0, 0};
  return camera;
}

}  // namespace

Site make_workcell_site() {
  Site site;
  site.name = "workcell";
  SiteBuilder builder(site);
  const std::uint32_t room = builder.part("room", false);
  WorkcellThings things(builder, room);
  things.build_shell(kRoom);
  things.build_bench({2.5, 3.0}, {2.4, 1.0}, kBenchTop);
  things.build_shelf({0.85, 4.19}, 3.3);
  things.build_side_rack();
  things.build_machine();

  const arm::Parts parts = arm::build(site, builder, room, kWorldFromArm);
  const std::uint32_t workpiece = builder.part("workpiece", true);
  builder.begin_object();
  const std::uint32_t body =
      builder.surface({Material::label, {0.16F, 0.42F, 0.70F}, {0.80F, 0.15F, 0.12F}, 50, "COOLANT"});
  const std::uint32_t lid = builder.surface({Material::paint, {0.85F, 0.83F, 0.20F}, {0, 0, 0}, 51, ""});
  builder.lathe(workpiece, {},
                {{kWorkpieceRadius, 0, body}, {kWorkpieceRadius, 0.125, lid}, {0.018, 0.15, lid}, {0.018, 0.168, lid}},
                12, lid, lid);
  builder.end_object();
  site.moving_occluders.push_back({workpiece, {0, 0, 0.03}, {0, 0, 0.13}, kWorkpieceRadius});
  things.fill_up_to(kPolygons);

  const auto slow = [](double phase, double strength) {
    return [=](double t) { return 1 + strength * std::sin(2 * std::numbers::pi * t / 17.0 + phase); };
  };
  site.lights.push_back(
      {{1.5, 2.3, 2.36}, {0.6, 0, 0}, {0, 0.15, 0}, {0, 0, -1}, {1.0F, 0.97F, 0.90F}, 1.55, slow(0.0, 0.10)});
  site.lights.push_back(
      {{3.5, 2.0, 2.36}, {0.6, 0, 0}, {0, 0.15, 0}, {0, 0, -1}, {1.0F, 0.97F, 0.90F}, 1.55, slow(0.0, 0.10)});
  site.lights.push_back(
      {{4.0, 0.06, 1.6}, {0.5, 0, 0}, {0, 0, 0.45}, {0, 1, 0}, {0.80F, 0.90F, 1.0F}, 2.2, slow(1.6, 0.12)});
  site.ambient = {0.30F, 0.31F, 0.33F};
  site.ambient_over_time = slow(0.6, 0.10);

  site.cameras = {stereo_camera("left", true), stereo_camera("right", false)};
  site.instants = 320;
  site.world_from_camera = [](std::size_t camera, double t) {
    constexpr double kBaseline = 0.11;
    return world_from_head(t) * Pose{glm::dquat(1, 0, 0, 0), {camera == 0 ? -kBaseline / 2 : kBaseline / 2, 0, 0}};
  };
  const std::size_t part_count = site.mesh.part_names.size();
  site.world_from_part = [parts, workpiece, part_count](double t) {
    std::vector<Pose> poses(part_count);
    arm::place(parts, kWorldFromArm, joints(t), opening(t), poses);
    poses[workpiece] = world_from_workpiece(t);
    return poses;
  };
  site.joint_names = {"joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7", "gripper"};
  site.joints = [](double t) {
    const arm::JointAngles q = joints(t);
    std::vector<double> result(q.begin(), q.end());
    result.push_back(opening(t));
    return result;
  };
  site.model_faces = site.mesh.faces.size();
  site.model_vertices = site.mesh.vertices.size();
  assert(site.model_faces == kPolygons);

  return site;
}

}  // namespace foreview::synthetic
