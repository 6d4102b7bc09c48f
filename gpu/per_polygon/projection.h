#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::per_polygon {

enum class Fate { visible, back_face, outside, too_small };  ///< rule 2, in its order

/// A rectangle of whole pixels; empty where width or height is 0.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
};

/// One polygon as a camera sees it (spec 3; rule 2 of PerPolygonExtraction), in double precision.
struct ProjectedPolygon {
  Fate fate = Fate::outside;
  PixelBox box;             ///< grown by 3 pixels and cut to the picture; empty where the polygon is outside
  int shorter_side = 0;     ///< pixels, of the box before growing, cut to the picture
  glm::dvec2 reference{0};  ///< pixel that the following is relative to: near the box, so that floats suffice
  /// 1/z of the plane at a pixel: slope . (pixel - reference) + at_reference, kept between least and greatest, which
  /// are those of the polygon's part in front of the near plane (1/m).
  glm::dvec2 inverse_z_slope{0};
  double inverse_z_at_reference = 0, least_inverse_z = 0, greatest_inverse_z = 0;
  /// The clipped projection, relative to `reference`, such that cross(direction, p - from) >= 0 inside. Cut off some
  /// way outside the box: nothing there matters, and coordinates stay small. Empty where the polygon is nowhere near
  /// the box.
  struct Edge {
    glm::dvec2 from{0}, direction{1, 0};  ///< direction of unit length
    double length = 0;
  };
  std::vector<Edge> outline;
};

/// How far outside the box the outline is cut off: more than the band that the occlusion test judges.
inline constexpr double kOutlineMargin = 8;  ///< pixels

/// Projects polygons one after the other, reusing its memory.
class Projector {
 public:
  /// `camera` is taken without distortion. `near_plane` in metres.
  Projector(const CameraModel& camera, double near_plane) : camera_(camera), near_(near_plane) {}
  /// `corners_in_camera`: the polygon's corners in the optical frame, counter-clockwise seen from the front;
  /// `normal_in_camera` and `offset`: dot(normal, p) == offset on its plane.
  void project(const std::vector<glm::dvec3>& corners_in_camera, const glm::dvec3& normal_in_camera, double offset,
               ProjectedPolygon& result);

 private:
  CameraModel camera_;
  double near_;
  std::vector<glm::dvec3> clipped_;
  std::vector<glm::dvec2> projected_, scratch_;
};

}  // namespace foreview::per_polygon
