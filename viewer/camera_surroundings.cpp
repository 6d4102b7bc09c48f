#include "foreview/viewer/camera_surroundings.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview {
namespace {

/// Of the world's axes the one along which the pictures' tops point on average, if it is clearly one.
glm::dvec3 find_up(std::span<const Pose> world_from_cameras) {
  glm::dvec3 sum(0);
  for (const Pose& pose : world_from_cameras) sum += pose.rotate({0, -1, 0});
  const glm::dvec3 mean = sum / std::max<double>(1, static_cast<double>(world_from_cameras.size()));
  int axis = 2;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(mean[i]) > std::abs(mean[axis])) axis = i;
  }
  const double others = std::max(std::abs(mean[(axis + 1) % 3]), std::abs(mean[(axis + 2) % 3]));
  glm::dvec3 up(0, 0, 1);
  if (std::abs(mean[axis]) > 0.35 && std::abs(mean[axis]) > 1.5 * others) {
    up = glm::dvec3(0);
    up[axis] = mean[axis] > 0 ? 1 : -1;
  }
  return up;
}

}  // namespace

CameraSurroundings find_surroundings(const PolygonModel& model, std::span<const Pose> world_from_part,
                                     std::span<const Pose> world_from_cameras) {
  CameraSurroundings result;
  result.up = find_up(world_from_cameras);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  glm::dvec3 least(kInfinite), greatest(-kInfinite);
  const auto for_all_corners = [&](const auto& use) {
    for (std::size_t p = 0; p < model.polygons().size(); ++p) {
      const Polygon& polygon = model.polygons()[p];
      if (polygon.is_backdrop) continue;
      for (const std::uint32_t corner : model.corners_of(p))
        use(world_from_part[polygon.part] * model.vertices()[corner]);
    }
  };
  for_all_corners([&](const glm::dvec3& point) {
    least = glm::min(least, point);
    greatest = glm::max(greatest, point);
  });
  if (!(least.x <= greatest.x)) return result;
  result.centre = 0.5 * (least + greatest);
  result.radius = 0;
  for_all_corners(
      [&](const glm::dvec3& point) { result.radius = std::max(result.radius, glm::distance(point, result.centre)); });
  result.radius = std::max(result.radius, 1e-6);
  return result;
}

}  // namespace foreview
