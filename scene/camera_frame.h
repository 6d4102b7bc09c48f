#pragma once
#include <opencv2/core/mat.hpp>
#include <vector>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"
#include "foreview/scene/timestamp.h"

namespace foreview {

/// M_t and P_t: the world at the moment a picture was taken. Only textures are extracted with it.
struct CaptureState {
  Timestamp stamp;
  Pose world_from_camera;             ///< optical frame
  std::vector<Pose> world_from_part;  ///< one per part of the model, same order
};

/// M_d and P_d: the world as commanded until now, and the operator's virtual camera. Only display uses it. A type of
/// its own, so that the compiler refuses to mix the two up.
struct PredictedState {
  Timestamp stamp;
  Pose world_from_camera;
  std::vector<Pose> world_from_part;
};

/// One picture with all that is known of its capture.
struct CameraFrame {
  cv::Mat picture;     ///< CV_8UC3, BGR, size of `camera`; distorted as the lens left it
  CameraModel camera;  ///< C_t
  CaptureState state;  ///< P_t, M_t
};

}  // namespace foreview
