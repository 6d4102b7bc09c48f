#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::oracle {

/// Pixels left..right-1, top..bottom-1.
struct Box {
  int left = 0, top = 0, right = 0, bottom = 0;
  [[nodiscard]] int width() const { return right - left; }
  [[nodiscard]] int height() const { return bottom - top; }
  [[nodiscard]] bool empty() const { return right <= left || bottom <= top; }
};

/// Step 2: a polygon cut at the near plane and projected by the camera without distortion.
struct ProjectedPolygon {
  std::vector<glm::dvec2> outline;  ///< pixels, convex; empty where all of it is behind the near plane
  glm::dvec3 normal{0};             ///< camera frame: dot(normal, p) == offset on the plane
  double offset = 0;                ///< metres; negative where the camera is in front
  CameraModel camera;
  Box box;          ///< whole pixels, cut to the picture, before growing
  Box grown_box;    ///< box grown by 3 pixels, cut to the picture
  double area = 0;  ///< square pixels of the outline

  [[nodiscard]] bool front() const { return offset < 0; }
  /// 1/z of the polygon's plane at a point of the picture.
  [[nodiscard]] double inverse_z(const glm::dvec2& pixel) const;
  /// Euclidean, pixels; positive inside.
  [[nodiscard]] double signed_distance(const glm::dvec2& pixel) const;
  [[nodiscard]] glm::dvec2 nearest_on_outline(const glm::dvec2& pixel) const;
};

[[nodiscard]] ProjectedPolygon project(const PolygonModel& model, std::size_t polygon, const CameraModel& camera,
                                       const CaptureState& state, double near_plane);

enum class Skip { none, back_face, outside, too_small };
[[nodiscard]] Skip skip_reason(const ProjectedPolygon& polygon);

}  // namespace foreview::oracle
