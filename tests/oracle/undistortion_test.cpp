#include "oracle/undistortion.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace foreview::oracle {
namespace {

CameraModel camera(DistortionModel model, const std::array<double, 8>& distortion) {
  CameraModel result;
  result.width = 60;
  result.height = 40;
  result.focal_length = {50, 52};
  result.principal_point = {30.5, 19.25};
  result.distortion_model = model;
  result.distortion = distortion;
  return result;
}

/// Blue is the column, green the row of the pixel's centre.
cv::Mat coordinates() {
  cv::Mat picture(40, 60, CV_8UC3);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      picture.at<cv::Vec3b>(y, x) = {static_cast<unsigned char>(4 * x), static_cast<unsigned char>(4 * y), 9};
    }
  }
  return picture;
}

TEST(Undistortion, WithoutDistortionIsThePictureItselfAllUsable) {
  const UndistortedPicture result = undistort(coordinates(), camera(DistortionModel::plumb_bob, {}));
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      EXPECT_EQ(result.colour.at(x, y), glm::dvec3(4 * x, 4 * y, 9));
      EXPECT_EQ(result.usable.at(x, y), 1);
    }
  }
}

TEST(Undistortion, FindsWhereTheLensPutEachRay) {
  for (const CameraModel& lens : {camera(DistortionModel::plumb_bob, {-0.2, 0.05, 0.001, -0.002, 0.01}),
                                  camera(DistortionModel::fisheye, {-0.01, 0.003})}) {
    const UndistortedPicture result = undistort(coordinates(), lens);
    int usable = 0;
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 60; ++x) {
        if (result.usable.at(x, y) == 0) continue;
        ++usable;
        const glm::dvec2 seen_at = glm::dvec2(result.colour.at(x, y)) / 4.0 + 0.5;  // position in the lens's picture
        const glm::dvec3 ray = lens.ray_from_pixel(seen_at);
        const glm::dvec3 expected = lens.undistorted().ray_from_pixel({x + 0.5, y + 0.5});
        EXPECT_NEAR(glm::distance(ray, expected), 0, 1e-6) << x << ", " << y;
      }
    }
    EXPECT_EQ(usable, 60 * 40) << "a barrel lens sees all of it";
  }
}

TEST(Undistortion, PixelsBeyondTheLensPictureAreUnusable) {
  const UndistortedPicture result = undistort(coordinates(), camera(DistortionModel::plumb_bob, {0.5}));
  EXPECT_EQ(result.usable.at(30, 19), 1);
  EXPECT_EQ(result.usable.at(0, 0), 0);
  EXPECT_EQ(result.usable.at(59, 39), 0);
}

}  // namespace
}  // namespace foreview::oracle
