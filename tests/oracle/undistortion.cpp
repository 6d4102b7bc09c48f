#include "oracle/undistortion.h"

#include <cmath>

namespace foreview::oracle {
namespace {

constexpr double kPositionRounding = 2e-3;  // pixels that single precision may move a distorted position by

glm::dvec3 pixel(const cv::Mat& picture, int x, int y) {
  const auto& bgr = picture.at<cv::Vec3b>(y, x);
  return {bgr[0], bgr[1], bgr[2]};
}

bool taps_inside(const cv::Mat& picture, const glm::dvec2& position) {
  const double x = std::floor(position.x - 0.5), y = std::floor(position.y - 0.5);
  return x >= 0 && y >= 0 && x + 1 < picture.cols && y + 1 < picture.rows;
}

}  // namespace

UndistortedPicture undistort(const cv::Mat& picture, const CameraModel& camera) {
  UndistortedPicture result;
  result.colour = ColourImage(camera.width, camera.height);
  result.usable = Flags(camera.width, camera.height, 1);
  result.doubtful = Flags(camera.width, camera.height, 0);
  const CameraModel pinhole = camera.undistorted();
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (!camera.is_distorted()) {
        result.colour.at(x, y) = pixel(picture, x, y);
        continue;
      }
      const glm::dvec2 p = camera.pixel_from_camera(pinhole.ray_from_pixel({x + 0.5, y + 0.5}));
      const bool inside = taps_inside(picture, p);
      for (const double dx : {-kPositionRounding, kPositionRounding}) {
        for (const double dy : {-kPositionRounding, kPositionRounding}) {
          if (taps_inside(picture, p + glm::dvec2(dx, dy)) != inside) result.doubtful.at(x, y) = 1;
        }
      }
      result.usable.at(x, y) = inside ? 1 : 0;
      if (!inside) continue;
      const int left = static_cast<int>(std::floor(p.x - 0.5)), top = static_cast<int>(std::floor(p.y - 0.5));
      const double fx = p.x - 0.5 - left, fy = p.y - 0.5 - top;
      result.colour.at(x, y) =
          pixel(picture, left, top) * (1 - fx) * (1 - fy) + pixel(picture, left + 1, top) * fx * (1 - fy) +
          pixel(picture, left, top + 1) * (1 - fx) * fy + pixel(picture, left + 1, top + 1) * fx * fy;
    }
  }
  return result;
}

}  // namespace foreview::oracle
