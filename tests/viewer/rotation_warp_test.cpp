#include "foreview/viewer/rotation_warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

namespace foreview {
namespace {

CameraModel camera(int width, int height, double focal_length) {
  CameraModel result;
  result.width = width;
  result.height = height;
  result.focal_length = {focal_length, focal_length * 1.1};
  result.principal_point = {width * 0.5 + 1.25, height * 0.5 - 0.75};
  return result;
}

/// A smooth colour for every direction in the world, so that any camera's picture can be told.
cv::Vec3d colour(const glm::dvec3& direction) {
  const glm::dvec3 d = glm::normalize(direction);
  return {128 + 100 * std::sin(4 * d.x), 128 + 100 * std::sin(5 * d.y + 1), 128 + 100 * std::cos(3 * d.z + 4 * d.x)};
}

cv::Mat picture_of_directions(const CameraModel& camera, const Pose& world_from_camera) {
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const cv::Vec3d c = colour(world_from_camera.rotate(camera.ray_from_pixel({x + 0.5, y + 0.5})));
      picture.at<cv::Vec3b>(y, x) =
          cv::Vec3b(cv::saturate_cast<unsigned char>(c[0]), cv::saturate_cast<unsigned char>(c[1]),
                    cv::saturate_cast<unsigned char>(c[2]));
    }
  }
  return picture;
}

TEST(RotationWarp, WithoutRotationKeepsThePicture) {
  const CameraModel lens = camera(40, 30, 35);
  const Pose pose{glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)), {1, 2, 3}};
  const cv::Mat picture = picture_of_directions(lens, pose);
  Pose moved = pose;
  moved.translation = {5, -4, 3};
  EXPECT_EQ(cv::norm(warp_by_rotation(picture, lens, pose, lens, moved), picture, cv::NORM_INF), 0);
}

TEST(RotationWarp, ShowsWhatTheTurnedCameraSees) {
  const CameraModel lens = camera(120, 90, 110), other = camera(100, 80, 95);
  const Pose before{glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)), {1, 2, 3}};
  const Pose turn{glm::angleAxis(0.15, glm::normalize(glm::dvec3(0.3, 1, 0.5))), {0.1, 0, 0}};
  const Pose now = before * turn;
  const cv::Mat warped = warp_by_rotation(picture_of_directions(lens, before), lens, before, other, now);
  const cv::Mat expected = picture_of_directions(other, now);
  ASSERT_EQ(warped.size(), expected.size());
  int compared = 0;
  for (int y = 0; y < warped.rows; ++y) {
    for (int x = 0; x < warped.cols; ++x) {
      const glm::dvec3 ray = turn.rotate(other.ray_from_pixel({x + 0.5, y + 0.5}));
      const glm::dvec2 pixel = lens.pixel_from_camera(ray);
      if (!(pixel.x > 0.5 && pixel.y > 0.5 && pixel.x < 119.5 && pixel.y < 89.5)) continue;
      ++compared;
      ASSERT_LE(cv::norm(warped.at<cv::Vec3b>(y, x), expected.at<cv::Vec3b>(y, x), cv::NORM_INF), 2) << x << ' ' << y;
    }
  }
  EXPECT_GT(compared, 4000);
  EXPECT_LT(compared, 8000);
}

TEST(RotationWarp, TurningRightMovesTheSceneLeft) {
  const CameraModel lens = camera(101, 75, 100);
  cv::Mat picture(75, 101, CV_8UC3, cv::Scalar::all(0));
  picture.at<cv::Vec3b>(36, 51) = {255, 255, 255};
  // y points down, so a positive angle about it turns z towards x: to the right.
  const Pose right{glm::angleAxis(std::atan(0.2), glm::dvec3(0, 1, 0)), {0, 0, 0}};
  const cv::Mat warped = warp_by_rotation(picture, lens, Pose{}, lens, right);
  int brightest_x = -1, brightest = 0;
  for (int x = 0; x < 101; ++x) {
    if (warped.at<cv::Vec3b>(36, x)[0] > brightest) brightest_x = x, brightest = warped.at<cv::Vec3b>(36, x)[0];
  }
  EXPECT_NEAR(brightest_x, 51 - 20, 1);
}

TEST(RotationWarp, OutsideTakesTheRimAndBehindIsNoCrash) {
  const CameraModel lens = camera(40, 30, 35);
  cv::Mat picture(30, 40, CV_8UC3, cv::Scalar(10, 20, 30));
  const Pose quarter{glm::angleAxis(1.2, glm::dvec3(0, 1, 0)), {0, 0, 0}};
  EXPECT_EQ(cv::norm(warp_by_rotation(picture, lens, Pose{}, lens, quarter), picture, cv::NORM_INF), 0);
  const Pose about{glm::dquat(0, 0, 1, 0), {0, 0, 0}};
  EXPECT_EQ(cv::norm(warp_by_rotation(picture, lens, Pose{}, lens, about), picture, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace foreview
