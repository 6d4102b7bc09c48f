#include "foreview/viewer/undistortion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace foreview {
namespace {

CameraModel camera(DistortionModel model, double k1) {
  CameraModel result;
  result.width = 96;
  result.height = 72;
  result.focal_length = {80, 82};
  result.principal_point = {49, 35};
  result.distortion_model = model;
  result.distortion[0] = k1;
  return result;
}

TEST(Undistortion, WithoutDistortionKeepsThePicture) {
  cv::Mat picture(72, 96, CV_8UC3);
  cv::randu(picture, 0, 256);
  const Undistortion undistortion(camera(DistortionModel::plumb_bob, 0));
  EXPECT_TRUE(undistortion.covers_all());
  EXPECT_EQ(cv::norm(undistortion.undistort(picture), picture, cv::NORM_INF), 0);
}

TEST(Undistortion, PutsPointsWhereTheStraightCameraSeesThem) {
  for (const CameraModel& lens : {camera(DistortionModel::plumb_bob, -0.3), camera(DistortionModel::plumb_bob, 0.1),
                                  camera(DistortionModel::fisheye, 0.05)}) {
    const Undistortion undistortion(lens);
    for (const glm::dvec3& point : {glm::dvec3(-0.4, -0.3, 1), glm::dvec3(0.45, 0.1, 1), glm::dvec3(0, 0, 1)}) {
      // A soft blob around the point's pixel, as the lens shows it.
      const glm::dvec2 seen = lens.pixel_from_camera(point), wanted = lens.undistorted().pixel_from_camera(point);
      cv::Mat picture(72, 96, CV_8UC3, cv::Scalar::all(0));
      for (int y = 0; y < 72; ++y) {
        for (int x = 0; x < 96; ++x) {
          const double square = (x + 0.5 - seen.x) * (x + 0.5 - seen.x) + (y + 0.5 - seen.y) * (y + 0.5 - seen.y);
          picture.at<cv::Vec3b>(y, x) = cv::Vec3b::all(cv::saturate_cast<unsigned char>(250 * std::exp(-square / 6)));
        }
      }
      const cv::Mat straight = undistortion.undistort(picture);
      double weight = 0, sum_x = 0, sum_y = 0;
      for (int y = 0; y < 72; ++y) {
        for (int x = 0; x < 96; ++x) {
          const double value = straight.at<cv::Vec3b>(y, x)[0];
          weight += value;
          sum_x += value * (x + 0.5);
          sum_y += value * (y + 0.5);
        }
      }
      EXPECT_NEAR(sum_x / weight, wanted.x, 0.15);
      EXPECT_NEAR(sum_y / weight, wanted.y, 0.15);
    }
  }
}

TEST(Undistortion, TellsWhatTheLensDidNotSee) {
  EXPECT_TRUE(Undistortion(camera(DistortionModel::plumb_bob, -0.3)).covers_all());
  const Undistortion pincushion(camera(DistortionModel::plumb_bob, 0.2));
  EXPECT_FALSE(pincushion.covers_all());
  EXPECT_EQ(pincushion.usable().at<unsigned char>(0, 0), 0);
  EXPECT_EQ(pincushion.usable().at<unsigned char>(35, 48), 255);
  const cv::Mat white(72, 96, CV_8UC3, cv::Scalar::all(255));
  const cv::Mat straight = pincushion.undistort(white);
  for (int y = 0; y < 72; ++y) {
    for (int x = 0; x < 96; ++x) {
      // Usable pixels have no black of the outside mixed in; the others have nothing else.
      ASSERT_EQ(straight.at<cv::Vec3b>(y, x)[0], pincushion.usable().at<unsigned char>(y, x)) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace foreview
