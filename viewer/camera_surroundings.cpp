#include "foreview/viewer/camera_surroundings.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

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

constexpr double kCrowdMargin = 1.3;
constexpr double kLookedAt = 0.4;  // tangent of the angle to a camera's axis

/// Whether it is around the middle of what one of the cameras sees; of many cameras only some are asked.
bool is_looked_at(const glm::dvec3& point, std::span<const Pose> world_from_cameras) {
  constexpr std::size_t kAsked = 16;
  const std::size_t step = std::max<std::size_t>(1, world_from_cameras.size() / kAsked);
  for (std::size_t i = 0; i < world_from_cameras.size(); i += step) {
    const glm::dvec3 p = world_from_cameras[i].inverse() * point;
    if (p.z > 0 && std::hypot(p.x, p.y) < kLookedAt * p.z) return true;
  }
  return false;
}

/// Of those that are looked at; of all where none is.
std::vector<glm::dvec3> middles_of_polygons(const PolygonModel& model, std::span<const Pose> world_from_part,
                                            std::span<const Pose> world_from_cameras) {
  std::vector<glm::dvec3> middles;
  for (std::size_t p = 0; p < model.polygons().size(); ++p) {
    if (model.polygons()[p].is_backdrop) continue;
    glm::dvec3 sum(0);
    for (const std::uint32_t corner : model.corners_of(p)) sum += model.vertices()[corner];
    middles.push_back(world_from_part[model.polygons()[p].part] *
                      (sum / static_cast<double>(model.corners_of(p).size())));
  }
  std::vector<glm::dvec3> looked_at;
  for (const glm::dvec3& middle : middles) {
    if (is_looked_at(middle, world_from_cameras)) looked_at.push_back(middle);
  }
  return looked_at.empty() ? middles : looked_at;
}

/// The element that `share` of all are below.
double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Ball {
  glm::dvec3 centre{0};
  double radius = 0;
};

/// Around the median, with four fifths of the points.
Ball ball_of_most(const std::vector<glm::dvec3>& points) {
  Ball ball;
  std::vector<double> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    ball.centre[axis] = quantile(values, 0.5);
  }
  for (std::size_t i = 0; i < points.size(); ++i) values[i] = glm::distance(points[i], ball.centre);
  ball.radius = quantile(values, 0.8);
  return ball;
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
  result.radius = 1e-6;
  for_all_corners(
      [&](const glm::dvec3& point) { result.radius = std::max(result.radius, glm::distance(point, result.centre)); });
  const Ball crowd = ball_of_most(middles_of_polygons(model, world_from_part, world_from_cameras));
  if (crowd.radius > 0 && kCrowdMargin * crowd.radius < 0.7 * result.radius) {
    result.centre = crowd.centre;
    result.radius = kCrowdMargin * crowd.radius;
  }
  return result;
}

}  // namespace foreview
