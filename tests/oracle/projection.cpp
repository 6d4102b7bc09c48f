#include "oracle/projection.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview::oracle {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

double signed_area(const std::vector<glm::dvec2>& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) sum += cross(outline[i], outline[(i + 1) % outline.size()]);
  return sum / 2;
}

std::vector<glm::dvec3> cut_at(const std::vector<glm::dvec3>& corners, double near_plane) {
  std::vector<glm::dvec3> result;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3& a = corners[i];
    const glm::dvec3& b = corners[(i + 1) % corners.size()];
    if (a.z >= near_plane) result.push_back(a);
    if ((a.z >= near_plane) != (b.z >= near_plane)) {
      glm::dvec3 cut = a + (b - a) * ((near_plane - a.z) / (b.z - a.z));
      cut.z = near_plane;
      result.push_back(cut);
    }
  }
  return result;
}

int to_pixel(double coordinate, int size) {
  return static_cast<int>(std::clamp(coordinate, 0.0, static_cast<double>(size)));
}

glm::dvec2 nearest_on_segment(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  const double length2 = glm::dot(b - a, b - a);
  if (length2 == 0) return a;
  return a + (b - a) * std::clamp(glm::dot(p - a, b - a) / length2, 0.0, 1.0);
}

}  // namespace

double ProjectedPolygon::inverse_z(const glm::dvec2& pixel) const {
  return glm::dot(normal, camera.ray_from_pixel(pixel)) / offset;
}

glm::dvec2 ProjectedPolygon::nearest_on_outline(const glm::dvec2& pixel) const {
  glm::dvec2 nearest = outline.front();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2 candidate = nearest_on_segment(outline[i], outline[(i + 1) % outline.size()], pixel);
    if (glm::distance(candidate, pixel) < glm::distance(nearest, pixel)) nearest = candidate;
  }
  return nearest;
}

double ProjectedPolygon::signed_distance(const glm::dvec2& pixel) const {
  const double winding = signed_area(outline) > 0 ? 1 : -1;
  bool inside = true;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2& a = outline[i];
    const glm::dvec2& b = outline[(i + 1) % outline.size()];
    if (winding * cross(b - a, pixel - a) < 0) inside = false;
  }
  const double distance = glm::distance(nearest_on_outline(pixel), pixel);
  return inside ? distance : -distance;
}

ProjectedPolygon project(const PolygonModel& model, std::size_t index, const CameraModel& camera,
                         const CaptureState& state, double near_plane) {
  const Polygon& polygon = model.polygons()[index];
  const Pose camera_from_part = state.world_from_camera.inverse() * state.world_from_part[polygon.part];
  ProjectedPolygon result;
  result.camera = camera.undistorted();
  result.normal = camera_from_part.rotate(polygon.normal);
  result.offset = polygon.offset + glm::dot(result.normal, camera_from_part.translation);

  std::vector<glm::dvec3> corners;
  for (std::size_t i = 0; i < polygon.corner_count; ++i) corners.push_back(camera_from_part * model.corner(index, i));
  for (const glm::dvec3& corner : cut_at(corners, near_plane)) {
    result.outline.push_back(result.camera.pixel_from_camera(corner));
  }
  if (result.outline.empty()) return result;
  result.area = std::abs(signed_area(result.outline));

  glm::dvec2 least = result.outline.front(), greatest = least;
  for (const glm::dvec2& p : result.outline) {
    least = {std::min(least.x, p.x), std::min(least.y, p.y)};
    greatest = {std::max(greatest.x, p.x), std::max(greatest.y, p.y)};
  }
  least += 1e-6;
  greatest -= 1e-6;
  const int w = camera.width, h = camera.height;
  result.box = {to_pixel(std::floor(least.x), w), to_pixel(std::floor(least.y), h), to_pixel(std::ceil(greatest.x), w),
                to_pixel(std::ceil(greatest.y), h)};
  result.grown_box = {std::max(result.box.left - 3, 0), std::max(result.box.top - 3, 0),
                      std::min(result.box.right + 3, w), std::min(result.box.bottom + 3, h)};
  return result;
}

Skip skip_reason(const ProjectedPolygon& polygon) {
  if (!polygon.front()) return Skip::back_face;
  if (polygon.box.empty()) return Skip::outside;
  if (polygon.area < 0.05) return Skip::too_small;
  return Skip::none;
}

}  // namespace foreview::oracle
