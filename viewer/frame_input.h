#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "foreview/scene/camera_frame.h"
#include "foreview/viewer/staleness.h"

namespace foreview {

/// A picture for the frame: as the operator's camera took it (CV_8UC3 BGR, its size, distorted). `key` names it: it is
/// brought to the GPU once, when a frame needs it whose key differs from the last one's.
struct FramePicture {
  cv::Mat picture;  ///< empty: none
  std::uint64_t key = 0;
};

/// All that a frame shows of a display instant, but for the textures. Keep one and change it from frame to frame: it
/// owns memory.
struct FrameInput {
  Timestamp moment;                         ///< that the frame shows: ages count from it
  std::optional<PredictedState> predicted;  ///< M_d, and P_d, the operator's camera; none: no predicted view
  std::optional<CameraModel> camera;        ///< the operator's, as registered; none: as it is known without
  std::optional<CaptureState> capture;      ///< M_t, P_t of the delayed picture: for its edges and its cone
  FramePicture delayed;                     ///< newest picture used
  /// The picture taken at `moment`, from where `predicted` sees it, for the difference; empty where nobody knows it.
  FramePicture truth;
  Staleness staleness;

  /// The operator's camera without its distortion; `known`: the same, not registered.
  [[nodiscard]] CameraModel camera_or(const CameraModel& known) const {
    // Registered may be one of before the camera became another one.
    if (!camera || camera->width != known.width || camera->height != known.height) return known;
    return camera->undistorted();
  }
};

}  // namespace foreview
