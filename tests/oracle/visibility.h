#pragma once
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"
#include "oracle/image.h"

namespace foreview::oracle {

/// A surface at a pixel's centre.
struct Hit {
  int polygon = -1;      ///< -1: nothing
  double inverse_z = 0;  ///< 1 / metres, 0: nothing
};

/// Step 1: what the undistorted camera sees at each pixel's centre.
struct Visibility {
  Image<Hit> nearest;
  /// All that a rasteriser may find nearest, given that it may move edges by `kEdgeRounding` and depths by a relative
  /// 1e-5. One hit where there is no doubt.
  Image<std::vector<Hit>> candidates;
};
/// Rasterisers place corners on a grid of at least 1/256 pixel: an edge may be off by that much, plus rounding.
inline constexpr double kEdgeRounding = 1.0 / 128;  // pixels

[[nodiscard]] Visibility visibility(const PolygonModel& model, const CameraModel& camera, const CaptureState& state,
                                    double near_plane);

}  // namespace foreview::oracle
