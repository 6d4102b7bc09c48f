#pragma once
#include <glm/vec3.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/camera_model.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// Where ghosts appear. Errors of registration put an occluder's pixels on the surface behind it, just outside the
/// occluder's contour; PSNR over a whole picture is blind to them, so they are measured by themselves.
///
/// Surfaces are given as PredictedView::render_surface() gives them: `polygon` CV_32S (index or -1), `inverse_z` CV_32F
/// (1/m, 0 for nothing), at pixel centres, for a camera without distortion.
struct SurfaceMap {
  cv::Mat polygon;
  cv::Mat inverse_z;
};

inline constexpr double kSilhouetteReach = 12;        ///< pixels outside a contour that count
inline constexpr int kGhostDisplacement = 6;          ///< pixels a right colour may be out of place and be no ghost
inline constexpr double kSilhouetteTolerance = 0.02;  ///< relative gap of 1/z from which on two surfaces are apart

/// 1/z of each polygon's plane as a linear function of the pixel: dot(plane, (u, v, 1)). Zero where the plane passes
/// through the camera.
[[nodiscard]] std::vector<glm::dvec3> inverse_depth_planes(const PolygonModel& model, const CameraModel& camera,
                                                           const Pose& world_from_camera,
                                                           const std::vector<Pose>& world_from_part);

/// CV_8U, 255 at pixels within `reach` pixels (Euclidean, along the surface behind: not across another contour) outside
/// an occluder's contour. A contour runs between two pixels side by side whose owners' planes gap midway by more than
/// kSilhouetteTolerance, on the same side at both pixels' centres (design 5.3): slanted surfaces, ridges and creases
/// are none. "Outside" is the farther surface's side.
[[nodiscard]] cv::Mat beyond_contours(const SurfaceMap& surface, const std::vector<glm::dvec3>& planes,
                                      double reach = kSilhouetteReach);

/// CV_8U of the predicted view's size, 255 at pixels whose surface point is visible in the used picture (same owner, or
/// the same depth there within 1 %) and lies there beyond a contour. `predicted` is the surface seen by `camera` in
/// `state`; `used` the surface at `used_state` as the picture's camera `used_camera` saw it.
[[nodiscard]] cv::Mat pixels_beyond_silhouettes(const PolygonModel& model, const CameraModel& camera,
                                                const PredictedState& state, const SurfaceMap& predicted,
                                                const CameraModel& used_camera, const CaptureState& used_state,
                                                const SurfaceMap& used);

}  // namespace foreview
