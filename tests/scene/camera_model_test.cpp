#include "foreview/scene/camera_model.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <opencv2/calib3d.hpp>

namespace foreview {
namespace {

CameraModel distorted_camera(DistortionModel model) {
  CameraModel camera;
  camera.width = 751;
  camera.height = 570;
  camera.focal_length = {640, 645};
  camera.principal_point = {371.5, 290.25};
  camera.distortion_model = model;
  if (model == DistortionModel::plumb_bob) camera.distortion = {-0.28, 0.09, 0.0007, -0.0004, -0.013, 0.01, 0.002, 0};
  if (model == DistortionModel::fisheye) camera.distortion = {-0.012, 0.004, -0.002, 0.0003};
  return camera;
}

TEST(CameraModel, DistortsAsOpenCvDoes) {
  for (const DistortionModel model : {DistortionModel::plumb_bob, DistortionModel::fisheye}) {
    const CameraModel camera = distorted_camera(model);
    const glm::dvec3 point{0.31, -0.22, 0.9};
    const cv::Matx33d k(640, 0, camera.principal_point.x - 0.5, 0, 645, camera.principal_point.y - 0.5, 0, 0, 1);
    std::vector<cv::Point2d> pixels;
    const std::vector<cv::Point3d> points{{point.x, point.y, point.z}};
    if (model == DistortionModel::fisheye) {
      cv::fisheye::projectPoints(points, pixels, cv::Vec3d(), cv::Vec3d(), k,
                                 std::vector<double>(camera.distortion.begin(), camera.distortion.begin() + 4));
    } else {
      cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k,
                        std::vector<double>(camera.distortion.begin(), camera.distortion.end()), pixels);
    }
    const glm::dvec2 pixel = camera.pixel_from_camera(point);
    EXPECT_NEAR(pixel.x, pixels[0].x + 0.5, 1e-9);
    EXPECT_NEAR(pixel.y, pixels[0].y + 0.5, 1e-9);
  }
}

TEST(CameraModel, UndistortsWhatItDistortedAllOverThePicture) {
  for (const DistortionModel model : {DistortionModel::plumb_bob, DistortionModel::fisheye}) {
    const CameraModel camera = distorted_camera(model);
    for (double v = 0; v <= 570; v += 57) {
      for (double u = 0; u <= 751; u += 75.1) {
        const glm::dvec2 back = camera.pixel_from_camera(camera.ray_from_pixel({u, v}) * 2.5);
        EXPECT_NEAR(back.x, u, 1e-6);
        EXPECT_NEAR(back.y, v, 1e-6);
      }
    }
  }
}

TEST(CameraModel, ClipCoordinatesLandOnTheSamePixelWithReversedDepth) {
  const CameraModel camera = distorted_camera(DistortionModel::none);
  const glm::dvec3 point{0.31, -0.22, 1.7};
  const glm::dvec4 clip = camera.clip_from_camera(0.05) * glm::dvec4(point, 1);
  const glm::dvec2 pixel = camera.pixel_from_camera(point);
  EXPECT_NEAR((clip.x / clip.w + 1) / 2 * camera.width, pixel.x, 1e-9);
  EXPECT_NEAR((clip.y / clip.w + 1) / 2 * camera.height, pixel.y, 1e-9);
  EXPECT_NEAR(clip.z / clip.w, 0.05 / 1.7, 1e-12);
}

}  // namespace
}  // namespace foreview
