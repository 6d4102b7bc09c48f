#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/scene/camera_model.h"
#include "oracle/image.h"

namespace foreview::oracle {

/// Step 0: the picture of the undistorted camera.
struct UndistortedPicture {
  ColourImage colour;
  Flags usable;    ///< all four taps lay in the lens's picture
  Flags doubtful;  ///< usable or not is decided by less than rounding can move it
};
/// `picture` is CV_8UC3 of the camera's size.
[[nodiscard]] UndistortedPicture undistort(const cv::Mat& picture, const CameraModel& camera);

}  // namespace foreview::oracle
