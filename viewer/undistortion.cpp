#include "foreview/viewer/undistortion.h"

#include <cassert>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

namespace foreview {

bool is_same_camera(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.focal_length == b.focal_length &&
         a.principal_point == b.principal_point && a.distortion_model == b.distortion_model &&
         a.distortion == b.distortion;
}

Undistortion::Undistortion(const CameraModel& camera)
    : usable_(camera.height, camera.width, CV_8UC1, cv::Scalar::all(255)) {
  if (!camera.is_distorted()) return;
  const CameraModel straight = camera.undistorted();
  source_.create(camera.height, camera.width, CV_32FC2);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const glm::dvec2 pixel = camera.pixel_from_camera(straight.ray_from_pixel({x + 0.5, y + 0.5})) - 0.5;
      const bool inside = pixel.x >= 0 && pixel.x <= camera.width - 1 && pixel.y >= 0 && pixel.y <= camera.height - 1;
      // Outside, any place far off the picture does; the true one may not fit OpenCV's integers.
      source_.at<cv::Vec2f>(y, x) =
          inside ? cv::Vec2f(static_cast<float>(pixel.x), static_cast<float>(pixel.y)) : cv::Vec2f(-9, -9);
      if (inside) continue;
      usable_.at<unsigned char>(y, x) = 0;
      covers_all_ = false;
    }
  }
}

cv::Mat Undistortion::undistort(const cv::Mat& picture) const {
  assert(picture.type() == CV_8UC3 && picture.size() == usable_.size());
  if (source_.empty()) return picture.clone();
  cv::Mat result;
  cv::remap(picture, result, source_, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return result;
}

}  // namespace foreview
