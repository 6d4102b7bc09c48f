#include "foreview/viewer/operator_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>
#include <vector>

namespace foreview {
namespace {

constexpr double kQuarter = 1.57079632679489662;
const glm::dvec3 kUp{0, 0, 1};

Pose upright(const glm::dvec3& eye = {1, -4, 1.5}, const glm::dvec3& target = {0.2, 0.1, 0.5}) {
  return looking_at(eye, target, kUp);
}

Pose leaning(double angle) {
  Pose pose = upright();
  pose.rotation = pose.rotation * glm::angleAxis(angle, glm::dvec3(0, 0, 1));
  return pose;
}

double lean(const Pose& pose) {
  return glm::dot(pose.rotate({1, 0, 0}), kUp);
}

void expect_same(const Pose& a, const Pose& b, double tolerance) {
  EXPECT_NEAR(glm::distance(a.translation, b.translation), 0, tolerance);
  EXPECT_NEAR(angle_between(a, b), 0, tolerance);
}

OperatorCamera camera_at(const Pose& pose, CameraMode mode) {
  OperatorCamera camera({{0, 0, 0.5}, 2.0, kUp});
  camera.advance(0, pose);
  camera.set_mode(mode);
  camera.advance(10, pose);
  return camera;
}

CameraModel vga() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.focal_length = {500, 510};
  camera.principal_point = {310, 250};
  return camera;
}

TEST(OperatorCamera, FollowsTheRecording) {
  OperatorCamera camera;
  for (int i = 0; i < 10; ++i) {
    const Pose pose = upright({1.0 + i, -4, 1});
    camera.advance(0.02, pose);
    EXPECT_EQ(camera.pose(), pose);
    EXPECT_EQ(camera.pose_ahead(0.01, upright()), upright());
    EXPECT_FALSE(camera.is_moving());
  }
}

TEST(OperatorCamera, EveryChangeOfModeBeginsAtThePresentPose) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> amount(-0.4, 0.4);
  for (const CameraMode from : kCameraModes) {
    for (const CameraMode to : kCameraModes) {
      OperatorCamera camera = camera_at(upright(), from);
      if (from != CameraMode::follow) camera.orbit(amount(random), amount(random));
      camera.advance(0.03, upright());
      if (from != CameraMode::follow) camera.look(amount(random), amount(random));
      const Pose before = camera.pose();
      camera.set_mode(to);
      expect_same(camera.pose(), before, 1e-12);
      // And goes on without a jump: 1/1000 s later it has not gone far.
      camera.advance(0.001, upright());
      EXPECT_LT(glm::distance(camera.pose().translation, before.translation), 0.01)
          << to_string(from) << " " << to_string(to);
      EXPECT_LT(angle_between(camera.pose(), before), 0.01) << to_string(from) << " " << to_string(to);
      camera.advance(2, upright());
      if (to == CameraMode::follow) {
        EXPECT_EQ(camera.pose(), upright());
      }
      if (to == CameraMode::look_around) {
        expect_same(camera.pose(), upright(), 1e-9);
      }
      if (to == CameraMode::free && from != CameraMode::free) {
        expect_same(camera.pose(), before, 1e-9);
      }
      EXPECT_FALSE(camera.is_moving());
    }
  }
}

TEST(OperatorCamera, AModeChosenAgainBeginsAnew) {
  OperatorCamera camera = camera_at(upright(), CameraMode::free);
  camera.orbit(1, 0.2);
  camera.advance(2, upright());
  EXPECT_GT(glm::distance(camera.pose().translation, upright().translation), 0.5);
  camera.set_mode(CameraMode::free);
  camera.advance(2, upright());
  expect_same(camera.pose(), upright(), 1e-9);
}

struct Input {
  const char* name;
  std::function<void(OperatorCamera&)> give;
  double tolerance;
};

std::vector<Input> inputs() {
  return {{"orbit", [](OperatorCamera& c) { c.orbit(0.7, -0.3); }, 1e-9},
          {"look", [](OperatorCamera& c) { c.look(-0.7, 0.2); }, 1e-9},
          {"pan", [](OperatorCamera& c) { c.pan(0.3, 0.4); }, 1e-9},
          {"dolly", [](OperatorCamera& c) { c.dolly(0.4); }, 1e-9},
          {"fly",
           [](OperatorCamera& c) {
             c.fly({0.5, -0.2, 1.5});
           },
           1e-9},
          {"roll", [](OperatorCamera& c) { c.roll(0.3); }, 1e-9},
          // These do not commute: steps of 1/240 s are taken.
          {"turn and fly",
           [](OperatorCamera& c) {
             c.look(0.7, 0.1);
             c.fly({0.5, -0.2, 1.5});
           },
           5e-3},
          {"orbit and pan",
           [](OperatorCamera& c) {
             c.orbit(0.7, 0.1);
             c.pan(0.3, 0.4);
           },
           5e-3}};
}

TEST(OperatorCamera, WhatIsDoneDoesNotDependOnTheFrameRate) {
  for (const Input& input : inputs()) {
    for (const double seconds : {0.02, 0.1, 0.5}) {
      OperatorCamera once = camera_at(upright(), CameraMode::free), often = once;
      input.give(once);
      input.give(often);
      once.advance(seconds, upright());
      for (int i = 0; i < 50; ++i) often.advance(seconds / 50, upright());
      SCOPED_TRACE(std::string(input.name) + " after " + std::to_string(seconds));
      expect_same(once.pose(), often.pose(), input.tolerance);
      EXPECT_GT(glm::distance(once.pose().translation, upright().translation) + angle_between(once.pose(), upright()),
                0.004);
    }
  }
}

TEST(OperatorCamera, NeverLeansUnlessAsked) {
  for (const double angle : {0.0, 0.3, -1.2}) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> amount(-0.6, 0.6);
    OperatorCamera camera = camera_at(leaning(angle), CameraMode::free);
    const double before = lean(camera.pose());
    for (int i = 0; i < 500; ++i) {
      camera.orbit(amount(random), amount(random));
      camera.look(amount(random), amount(random));
      camera.pan(amount(random), amount(random));
      camera.dolly(1 + amount(random));
      camera.fly({amount(random), amount(random), amount(random)});
      camera.advance(0.016, leaning(angle));
      ASSERT_NEAR(lean(camera.pose()), before, 1e-9) << i;
    }
    EXPECT_NEAR(glm::length(camera.pose().rotation), 1, 1e-12);
  }
}

TEST(OperatorCamera, DoesNotTurnOverTheVertical) {
  for (const double down : {0.05, -0.05}) {
    for (const CameraMode mode : {CameraMode::free, CameraMode::look_around}) {
      OperatorCamera camera = camera_at(upright(), mode);
      for (int i = 0; i < 200; ++i) {
        if (i % 2 == 0) camera.look(0, down);
        if (i % 2 == 1) camera.orbit(0, down);
        camera.advance(0.016, upright());
        ASSERT_LT(glm::dot(camera.pose().rotate({0, 1, 0}), kUp), 1e-9);
      }
      camera.advance(1, upright());
      // It got to the vertical, all the same.
      EXPECT_GT(std::abs(glm::dot(camera.pose().rotate({0, 0, 1}), kUp)), 0.999);
    }
  }
}

TEST(OperatorCamera, ACameraThatLooksStraightDownCanBeTurned) {
  const Pose down{glm::dquat(0, 1, 0, 0), {0, 0, 3}};  // x right, y towards -y, z down
  OperatorCamera camera = camera_at(down, CameraMode::free);
  expect_same(camera.pose(), down, 1e-12);
  camera.orbit(0.5, -0.4);
  camera.advance(2, down);
  EXPECT_NEAR(angle_between(camera.pose(), down), 0.63, 0.02);
  EXPECT_NEAR(lean(camera.pose()), 0, 1e-9);
}

TEST(OperatorCamera, OrbitKeepsThePivotInItsPlaceAndDistance) {
  OperatorCamera camera = camera_at(upright(), CameraMode::free);
  const glm::dvec3 pivot{0.3, 0.2, 0.9};
  const Pose before = camera.pose();
  camera.set_pivot(pivot);
  expect_same(camera.pose(), before, 1e-12);
  const glm::dvec3 seen = camera.pose().inverse() * pivot;
  camera.orbit(1.1, 0.2);
  for (int i = 0; i < 20; ++i) {
    camera.advance(0.02, upright());
    EXPECT_NEAR(glm::distance(camera.pose().inverse() * pivot, seen), 0, 1e-9);
  }
  EXPECT_GT(angle_between(camera.pose(), before), 0.9);
  // The near side goes along with the mouse: to the right means the camera goes to the left.
  EXPECT_LT((before.inverse() * camera.pose().translation).x, -0.5);
}

TEST(OperatorCamera, DollyPanLookAndFlyDoWhatTheySay) {
  const glm::dvec3 pivot{0.3, 0.2, 0.9};
  OperatorCamera start = camera_at(upright(), CameraMode::free);
  start.set_pivot(pivot);
  const glm::dvec3 seen = start.pose().inverse() * pivot;

  OperatorCamera camera = start;
  camera.dolly(0.5);
  camera.advance(3, upright());
  EXPECT_NEAR(glm::distance(camera.pose().inverse() * pivot, 0.5 * seen), 0, 1e-5);

  camera = start;
  const double metres = camera.metres_per_pixel(vga());
  camera.pan(20 * metres, -30 * metres);
  camera.advance(3, upright());
  const glm::dvec2 moved = vga().pixel_from_camera(camera.pose().inverse() * pivot) - vga().pixel_from_camera(seen);
  EXPECT_NEAR(moved.x, 20 * vga().focal_length.x / vga().focal_length.y, 0.01);
  EXPECT_NEAR(moved.y, -30, 0.01);

  camera = start;
  camera.look(0.3, 0.1);
  camera.advance(3, upright());
  EXPECT_NEAR(glm::distance(camera.pose().translation, upright().translation), 0, 1e-9);
  const glm::dvec3 was_ahead = camera.pose().inverse().rotate(upright().rotate({0, 0, 1}));
  EXPECT_LT(was_ahead.x, -0.25);  // turned to the right and down
  EXPECT_LT(was_ahead.y, -0.05);

  camera = start;
  camera.fly({0, 0, 2});
  camera.advance(1, upright());
  EXPECT_NEAR((upright().inverse() * camera.pose().translation).z, 2 * (1 - OperatorCamera::kSmoothing), 1e-6);
  EXPECT_TRUE(camera.is_moving());
  camera.fly({0, 0, 0});
  camera.advance(3, upright());
  EXPECT_NEAR((upright().inverse() * camera.pose().translation).z, 2, 1e-5);
  EXPECT_FALSE(camera.is_moving());
}

TEST(OperatorCamera, RollsAndLevelsWhenAsked) {
  OperatorCamera camera = camera_at(upright(), CameraMode::free);
  camera.roll(0.5);
  camera.advance(3, upright());
  EXPECT_NEAR(angle_between(camera.pose(), upright()), 0.5, 1e-5);
  EXPECT_NEAR(glm::distance(camera.pose().rotate({0, 0, 1}), upright().rotate({0, 0, 1})), 0, 1e-9);
  camera.level();
  camera.advance(3, upright());
  EXPECT_NEAR(lean(camera.pose()), 0, 1e-5);
  EXPECT_LT(glm::dot(camera.pose().rotate({0, 1, 0}), kUp), 0);
}

TEST(OperatorCamera, LookingAroundGoesAlongWithTheRecording) {
  OperatorCamera camera = camera_at(upright(), CameraMode::follow);
  camera.look(0.4, -0.1);  // begins to look around by itself
  EXPECT_EQ(camera.mode(), CameraMode::look_around);
  for (int i = 0; i < 100; ++i) {
    const Pose recorded = upright({1 + 0.01 * i, -4, 1.5});
    camera.advance(0.02, recorded);
    EXPECT_LT(glm::distance(camera.pose().translation, recorded.translation), 1e-12);
  }
  const Pose recorded = upright({1.99, -4, 1.5});
  EXPECT_NEAR(angle_between(camera.pose(), recorded), std::hypot(0.4, 0.1), 0.02);
}

TEST(OperatorCamera, AheadIsWhereItWillBe) {
  for (const Input& input : inputs()) {
    OperatorCamera camera = camera_at(upright(), CameraMode::free);
    input.give(camera);
    camera.advance(0.02, upright());
    const Pose now = camera.pose(), ahead = camera.pose_ahead(0.03, upright());
    expect_same(camera.pose(), now, 0);
    const CameraMotion motion = camera.motion();
    OperatorCamera soon = camera;
    soon.advance(0.001, upright());
    EXPECT_NEAR(glm::distance(now.translation + 0.001 * motion.velocity, soon.pose().translation), 0, 2e-3)
        << input.name;
    EXPECT_NEAR(0.001 * glm::length(motion.angular_velocity), angle_between(now, soon.pose()), 2e-3) << input.name;
    camera.advance(0.03, upright());
    expect_same(camera.pose(), ahead, 1e-12);
  }
}

TEST(OperatorCamera, OverviewSeesTheSceneAndTheCamera) {
  const CameraSurroundings surroundings{{0.5, 0, 1}, 1.5, kUp};
  OperatorCamera camera(surroundings);
  const CameraModel model = vga();
  camera.set_field_of_view(field_of_view(model));
  for (const Pose& recorded : {upright(), upright({0.4, 0.1, 1}, {0.5, 3, 1}), upright({-9, 3, 2}, {0, 0, 1}),
                               Pose{glm::dquat(0, 1, 0, 0), {0, 0, 4}}}) {
    const Pose pose = camera.overview_pose(recorded, field_of_view(model));
    EXPECT_NEAR(lean(pose), 0, 1e-9);
    EXPECT_GT(pose.translation.z, recorded.translation.z);
    std::vector<glm::dvec3> points{recorded.translation};
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        glm::dvec3 point = surroundings.centre;
        point[axis] += sign * surroundings.radius;
        points.push_back(point);
      }
    }
    for (const glm::dvec3& point : points) {
      const glm::dvec3 seen = pose.inverse() * point;
      ASSERT_GT(seen.z, 0);
      const glm::dvec2 pixel = model.pixel_from_camera(seen);
      EXPECT_TRUE(pixel.x > -5 && pixel.x < model.width + 5 && pixel.y > -15 && pixel.y < model.height + 15)
          << pixel.x << ", " << pixel.y;
    }
  }
}

TEST(OperatorCamera, AChoiceBringsTheViewBack) {
  for (const CameraMode mode : kCameraModes) {
    OperatorCamera camera = camera_at(upright(), mode);
    if (mode != CameraMode::follow) {
      camera.orbit(0.3, 0.2);
      camera.pan(0.1, 0.1);
      camera.dolly(1.3);
      camera.advance(3, upright());
    }
    ViewChoice choice;
    camera.store(choice);
    EXPECT_EQ(choice.camera, mode);
    OperatorCamera other({{0, 0, 0.5}, 2.0, kUp});
    other.apply(choice, vga(), upright());
    expect_same(other.pose(), camera.pose(), 1e-9);
    EXPECT_FALSE(other.is_moving());
  }
}

TEST(OperatorCamera, FieldOfView) {
  EXPECT_EQ(with_field_of_view(vga(), std::nullopt).focal_length, vga().focal_length);
  for (const double radians : {0.02, 0.5, 2 * std::atan(1.0), 2.7}) {
    const CameraModel camera = with_field_of_view(vga(), radians);
    EXPECT_NEAR(field_of_view(camera), radians, 1e-12);
    EXPECT_NEAR(camera.focal_length.x / camera.focal_length.y, 500.0 / 510, 1e-12) << "pixels stay square";
  }
  EXPECT_NEAR(field_of_view(with_field_of_view(vga(), 9.0)), kGreatestFieldOfView, 1e-12);
  EXPECT_LT(field_of_view(vga()), kQuarter);
}

PolygonModel box(const glm::dvec3& size) {
  RawMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) != 0 ? size.x : 0, (i & 2) != 0 ? size.y : 0, (i & 4) != 0 ? size.z : 0);
  }
  mesh.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  return build_polygon_model(mesh, {});
}

TEST(CameraSurroundings, BallAndUp) {
  const PolygonModel model = box({2, 4, 6});  // and a backdrop far away, which does not count
  std::vector<Pose> parts(model.parts().size());
  parts[0].translation = {10, 0, 0};
  std::vector<Pose> cameras;
  for (int i = 0; i < 8; ++i) cameras.push_back(looking_at({std::cos(i), std::sin(i), 1}, {0, 0, 0}, kUp));
  const CameraSurroundings found = find_surroundings(model, parts, cameras);
  EXPECT_NEAR(glm::distance(found.centre, glm::dvec3(11, 2, 3)), 0, 1e-9);
  EXPECT_NEAR(found.radius, std::sqrt(1 + 4 + 9), 1e-9);
  EXPECT_EQ(found.up, kUp);
  const glm::dvec3 minus_y{0, -1, 0};
  for (Pose& camera : cameras) camera = looking_at({0, 0, 0}, {1, 0.3, camera.translation.x}, minus_y);
  EXPECT_EQ(find_surroundings(model, parts, cameras).up, minus_y);
  // Looking along the vertical tells nothing: z it is.
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const double angle = static_cast<double>(i) * 0.5 * kQuarter;
    cameras[i].rotation = glm::dquat(0, 1, 0, 0) * glm::angleAxis(angle, glm::dvec3(0, 0, 1));
  }
  EXPECT_EQ(find_surroundings(model, parts, cameras).up, kUp);
  EXPECT_EQ(find_surroundings(model, parts, {}).up, kUp);
}

TEST(CameraSurroundings, InARoomWhatTheCamerasLookAt) {
  // A box of 0.4 m in a room of 10 m, its walls cut into many polygons.
  RawMesh mesh;
  const auto add_box = [&](const glm::dvec3& middle, double size, int cuts) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-0.5, 0.5}) {
        for (int k = 0; k < cuts * cuts; ++k) {
          const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
          for (const glm::ivec2 corner : {glm::ivec2(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
            glm::dvec3 p;
            p[axis] = side;
            p[(axis + 1) % 3] = static_cast<double>(k % cuts + corner.x) / cuts - 0.5;
            p[(axis + 2) % 3] = static_cast<double>(k / cuts + corner.y) / cuts - 0.5;
            mesh.vertices.push_back(middle + size * p);
          }
          mesh.faces.push_back({first, first + 1, first + 2, first + 3});
        }
      }
    }
  };
  add_box({0, 0, 0}, 10, 4);
  add_box({1, 1, -1}, 0.4, 8);
  ImportOptions options;
  options.merge_coplanar = false;
  const PolygonModel model = build_polygon_model(mesh, options);
  const std::vector<Pose> parts(model.parts().size());
  std::vector<Pose> cameras;
  for (int i = 0; i < 40; ++i) cameras.push_back(looking_at({-1 + 0.02 * i, -1, 0}, {1, 1, -1}, kUp));
  const CameraSurroundings found = find_surroundings(model, parts, cameras);
  EXPECT_LT(glm::distance(found.centre, glm::dvec3(1, 1, -1)), 0.3);
  EXPECT_GT(found.radius, 0.2);
  EXPECT_LT(found.radius, 3);
}

}  // namespace
}  // namespace foreview
