#include "foreview/calib/registration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "calib/painted_room.h"

namespace foreview {
namespace {

CameraModel small_camera() {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.focal_length = {260, 260};
  camera.principal_point = {160, 120};
  camera.name = "eye";
  return camera;
}

/// Looking around while walking through the middle of the room; pictures at 30 Hz.
Pose true_pose(int picture) {
  const double t = picture / 30.0;
  const glm::dvec3 eye(0.6 * std::sin(1.1 * t), 0.2 * std::sin(1.7 * t), -1.2 + 0.5 * std::sin(0.7 * t));
  return looking_at(eye, eye + glm::dvec3(0.6 * std::sin(0.8 * t), 0.2 * std::cos(t), 1), {0, -1, 0});
}

/// A stream of the room whose poses and camera are not quite what is recorded.
class Stream {
 public:
  explicit Stream(CameraModel recorded_camera = small_camera()) : recorded_camera_(std::move(recorded_camera)) {}

  struct Picture {
    Pose truth, recorded;
    CameraFrame registered;
  };
  /// `recorded_from_true`: of this picture.
  const Picture& add(const Pose& recorded_from_true) {
    return add(static_cast<int>(pictures_.size()), recorded_from_true);
  }
  /// Picture `number` of the walk.
  const Picture& add(int number, const Pose& recorded_from_true) {
    const Pose truth = true_pose(number), recorded = truth * recorded_from_true.inverse();
    CameraFrame frame;
    frame.picture = room_.picture(small_camera(), truth);
    frame.camera = recorded_camera_;
    frame.state = {Timestamp{number * 33'333'333LL}, recorded, std::vector<Pose>(model_.parts().size())};
    registration_.correct(frame);
    pictures_.push_back({truth, recorded, frame});
    return pictures_.back();
  }
  void leap() { registration_.leap(); }
  [[nodiscard]] const Registration& registration() const { return registration_; }
  [[nodiscard]] const std::vector<Picture>& pictures() const { return pictures_; }

  /// How far colours that picture `from` puts on the walls appear from where picture `to` shows them: median, pixels.
  [[nodiscard]] double displacement(std::size_t from, std::size_t to, bool registered) const {
    const Picture &a = pictures_[from], &b = pictures_[to];
    const CameraModel truth = small_camera();
    const CameraModel camera_a = registered ? a.registered.camera : recorded_camera_;
    const CameraModel camera_b = registered ? b.registered.camera : recorded_camera_;
    const Pose pose_a = registered ? a.registered.state.world_from_camera : a.recorded;
    const Pose pose_b = registered ? b.registered.state.world_from_camera : b.recorded;
    std::vector<double> distances;
    for (int y = 20; y < truth.height; y += 20) {
      for (int x = 20; x < truth.width; x += 20) {
        const glm::dvec2 pixel(x, y);
        const glm::dvec3 seen = room_.wall_at(b.truth.translation, b.truth.rotate(truth.ray_from_pixel(pixel)));
        const glm::dvec3 in_a = a.truth.inverse() * seen;
        if (in_a.z <= 0) continue;
        const glm::dvec2 pixel_a = truth.pixel_from_camera(in_a);
        if (pixel_a.x < 0 || pixel_a.y < 0 || pixel_a.x > truth.width || pixel_a.y > truth.height) continue;
        const glm::dvec3 painted = room_.wall_at(pose_a.translation, pose_a.rotate(camera_a.ray_from_pixel(pixel_a)));
        const glm::dvec3 shown = pose_b.inverse() * painted;
        if (shown.z > 0) distances.push_back(glm::distance(pixel, camera_b.pixel_from_camera(shown)));
      }
    }
    std::sort(distances.begin(), distances.end());
    return distances.empty() ? 1e9 : distances[distances.size() / 2];
  }

 private:
  test::PaintedRoom room_;
  PolygonModel model_ = room_.model();
  RayCaster rays_{model_};
  CameraModel recorded_camera_;
  Registration registration_{model_, rays_};
  std::vector<Picture> pictures_;
};

TEST(Registration, WhatFitsIsLeftAsItIs) {
  Stream stream;
  for (int i = 0; i < 120; ++i) {
    const auto& picture = stream.add({});
    EXPECT_EQ(picture.registered.state.world_from_camera, picture.recorded) << i;
    EXPECT_EQ(picture.registered.camera.focal_length, small_camera().focal_length) << i;
  }
  const RegistrationStatus status = stream.registration().status();
  EXPECT_FALSE(status.is_correcting);
  EXPECT_LT(status.error_recorded, 0.3);
  EXPECT_GT(status.fitting, 50U);
  EXPECT_EQ(stream.registration().registered_from_recorded(), Pose());
  EXPECT_EQ(status.searched, 99U) << "once it is known to fit, every fourth picture is enough";
}

TEST(Registration, FindsAMountAndALensThatAreOff) {
  CameraModel recorded = small_camera();
  recorded.focal_length *= 1.03;
  Stream stream(recorded);
  const Pose recorded_from_true{glm::angleAxis(0.03, glm::normalize(glm::dvec3(0.3, 1, 0.2))), {0.03, -0.02, 0.02}};
  for (int i = 0; i < 180; ++i) stream.add(recorded_from_true);
  EXPECT_TRUE(stream.registration().status().is_correcting);
  // Old textures in the newest picture, and the newest in old ones.
  for (const std::size_t from : {110U, 130U, 150U}) {
    EXPECT_GT(stream.displacement(from, 179, false), 1.0) << from;
    EXPECT_LT(stream.displacement(from, 179, true), 0.6) << from;
  }
  EXPECT_NEAR(stream.registration().camera()->focal_length.x, small_camera().focal_length.x, 1.5);
}

TEST(Registration, FollowsPosesThatDrift) {
  Stream stream;
  std::mt19937 random(3);
  std::normal_distribution<double> step(0, 1);
  MotionVector drift{};
  std::vector<double> recorded, registered;
  for (std::size_t i = 0; i < 180; ++i) {
    for (std::size_t k = 0; k < drift.size(); ++k) drift[k] = 0.95 * drift[k] + (k < 3 ? 0.002 : 0.003) * step(random);
    stream.add(motion_from(drift));
    if (i < 140) continue;
    recorded.push_back(stream.displacement(i - 40, i, false));
    registered.push_back(stream.displacement(i - 40, i, true));
  }
  std::sort(recorded.begin(), recorded.end());
  std::sort(registered.begin(), registered.end());
  EXPECT_GT(recorded[recorded.size() / 2], 2.0);
  EXPECT_LT(registered[registered.size() / 2], 0.25 * recorded[recorded.size() / 2]);
}

/// Median displacement of colours that a picture of the stream put there 40 before, over the last 40.
double displacement_at_the_end(const Stream& stream, const std::vector<std::size_t>& places, bool registered) {
  std::vector<double> displacements;
  for (std::size_t i = places.size() - 40; i < places.size(); ++i) {
    displacements.push_back(stream.displacement(places[i - 40], places[i], registered));
  }
  std::nth_element(displacements.begin(), displacements.begin() + 20, displacements.end());
  return displacements[20];
}

TEST(Registration, HistoryDoesNotDisturbTheNewestPictures) {
  for (const bool with_history : {false, true}) {
    Stream stream;
    std::mt19937 random(3);
    std::normal_distribution<double> step(0, 1);
    MotionVector drift{};
    std::vector<std::size_t> places, places_of_history;
    for (int i = 0; i < 160; ++i) {
      for (std::size_t k = 0; k < drift.size(); ++k) {
        drift[k] = 0.95 * drift[k] + (k < 3 ? 0.002 : 0.003) * step(random);
      }
      places.push_back(stream.pictures().size());
      stream.add(200 + i, motion_from(drift));
      if (!with_history || i >= 150) continue;
      // Newest first, and off another way.
      places_of_history.push_back(stream.pictures().size());
      stream.add(199 - i, Pose{glm::angleAxis(0.02 * std::sin(0.05 * i), glm::dvec3(0, 1, 0)), {0.005, 0.01, 0}});
    }
    const double recorded = displacement_at_the_end(stream, places, false);
    EXPECT_GT(recorded, 2.0);
    EXPECT_LT(displacement_at_the_end(stream, places, true), 0.25 * recorded) << with_history;
    if (!with_history) continue;
    EXPECT_LT(displacement_at_the_end(stream, places_of_history, true), 1.0);
  }
}

TEST(Registration, KnowsMountAndLensAfterALeapInTime) {
  CameraModel recorded = small_camera();
  recorded.focal_length *= 1.03;
  Stream stream(recorded);
  const Pose recorded_from_true{glm::angleAxis(0.03, glm::normalize(glm::dvec3(0.3, 1, 0.2))), {0.03, -0.02, 0.02}};
  for (int i = 0; i < 150; ++i) stream.add(60 + i, recorded_from_true);
  ASSERT_TRUE(stream.registration().status().is_correcting);
  stream.leap();
  stream.add(190, recorded_from_true);
  EXPECT_GT(stream.displacement(110, 150, false), 0.5);
  EXPECT_LT(stream.displacement(110, 150, true), 0.3);
  // Not only in agreement, but right.
  const auto& last = stream.pictures().back();
  EXPECT_GT(angle_between(last.recorded, last.truth), 0.029);
  EXPECT_LT(angle_between(last.registered.state.world_from_camera, last.truth), 0.01);
}

TEST(Registration, HoldsTheLastCorrectionAhead) {
  Stream stream;
  const Pose off{glm::angleAxis(0.015, glm::dvec3(0, 1, 0)), {0.01, 0, 0}};
  for (int i = 0; i < 120; ++i) stream.add(i / 20 % 2 == 0 ? Pose() : off);
  ASSERT_TRUE(stream.registration().status().is_correcting);
  const auto& last = stream.pictures().back();
  const Pose& true_then = last.registered.state.world_from_camera;
  const Pose now = stream.registration().registered_from_recorded() * last.recorded;
  EXPECT_LT(glm::distance(now.translation, true_then.translation), 1e-9);
  EXPECT_LT(angle_between(now, true_then), 1e-6);
  // A camera that goes on by as much as the record says is as far from there as the record says.
  const Pose motion{glm::angleAxis(0.3, glm::normalize(glm::dvec3(1, 2, 3))), {0.2, -0.1, 0.4}};
  const Pose later = stream.registration().registered_from_recorded() * (motion * last.recorded);
  EXPECT_NEAR(glm::distance(later.translation, now.translation),
              glm::distance((motion * last.recorded).translation, last.recorded.translation), 1e-9);
  EXPECT_NEAR(angle_between(later, now), 0.3, 1e-6);
}

TEST(Registration, BlankPicturesChangeNothing) {
  const test::PaintedRoom room;
  const PolygonModel model = room.model();
  const RayCaster rays(model);
  Registration registration(model, rays);
  for (int i = 0; i < 20; ++i) {
    CameraFrame frame{cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90)),
                      small_camera(),
                      {Timestamp{i * 33'333'333LL}, true_pose(i), std::vector<Pose>(model.parts().size())}};
    registration.correct(frame);
    EXPECT_EQ(frame.state.world_from_camera, true_pose(i));
  }
  EXPECT_EQ(registration.status().landmarks, 0U);
  EXPECT_EQ(registration.status().registered, 0U);
}

TEST(Registration, SurvivesTinyPicturesAndAChangeOfCamera) {
  const test::PaintedRoom room;
  const PolygonModel model = room.model();
  const RayCaster rays(model);
  Registration registration(model, rays);
  CameraModel camera = small_camera();
  for (const int size : {320, 1, 7, 320, 41, 64}) {
    camera.width = size;
    camera.height = std::max(1, size * 3 / 4);
    for (int i = 0; i < 6; ++i) {
      CameraFrame frame{room.picture(camera, true_pose(i)),
                        camera,
                        {Timestamp{i}, true_pose(i), std::vector<Pose>(model.parts().size())}};
      registration.correct(frame);
      EXPECT_EQ(frame.camera.width, size);
    }
  }
}

}  // namespace
}  // namespace foreview
