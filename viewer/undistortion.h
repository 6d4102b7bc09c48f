#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/scene/camera_model.h"

namespace foreview {

/// Whether pictures of the one are pictures of the other: all but the name.
[[nodiscard]] bool is_same_camera(const CameraModel& a, const CameraModel& b);

/// Takes the lens distortion out of a camera's pictures on the CPU: for showing and measuring; textures are undistorted
/// on the GPU by the same rule. The result belongs to camera.undistorted(): same size, focal length, principal point.
/// Each of its pixels takes the bilinear sample (positions rounded to 1/32 pixel) at the distorted position.
class Undistortion {
 public:
  explicit Undistortion(const CameraModel& camera);

  /// `picture` of the camera's size, CV_8UC3. Pixels that the lens did not see are black.
  [[nodiscard]] cv::Mat undistort(const cv::Mat& picture) const;
  /// CV_8U: 255 where the sample lies wholly within the lens's picture, else 0. Barrel distortion covers everything;
  /// pincushion does not.
  [[nodiscard]] const cv::Mat& usable() const { return usable_; }
  [[nodiscard]] bool covers_all() const { return covers_all_; }

 private:
  cv::Mat source_;  ///< CV_32FC2, OpenCV's pixel convention; empty without distortion
  cv::Mat usable_;
  bool covers_all_ = true;
};

}  // namespace foreview
