#include "foreview/viewer/rotation_warp.h"

#include <cassert>
#include <opencv2/imgproc.hpp>

namespace foreview {

cv::Mat warp_by_rotation(const cv::Mat& picture, const CameraModel& picture_camera,
                         const Pose& world_from_picture_camera, const CameraModel& camera,
                         const Pose& world_from_camera) {
  assert(picture.type() == CV_8UC3);
  assert(picture.cols == picture_camera.width && picture.rows == picture_camera.height);
  assert(!picture_camera.is_distorted() && !camera.is_distorted());
  const glm::dquat picture_from_camera =
      glm::conjugate(world_from_picture_camera.rotation) * world_from_camera.rotation;
  cv::Mat source(camera.height, camera.width, CV_32FC2);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const glm::dvec3 ray = picture_from_camera * camera.ray_from_pixel({x + 0.5, y + 0.5});
      cv::Vec2f& place = source.at<cv::Vec2f>(y, x);
      place = {-1e6F, -1e6F};
      if (!(ray.z > 1e-9)) continue;
      const glm::dvec2 pixel = picture_camera.pixel_from_camera(ray);
      // Far outside is outside all the same; without this the conversion to OpenCV's integers could overflow.
      if (!(glm::length(pixel) < 1e6)) continue;
      place = {static_cast<float>(pixel.x - 0.5), static_cast<float>(pixel.y - 0.5)};
    }
  }
  cv::Mat result;
  cv::remap(picture, result, source, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace foreview
