#include "foreview/scene/polygon_geometry.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview {

glm::dvec3 vector_area(std::span<const glm::dvec3> corners) {
  glm::dvec3 sum(0);
  // Relative to the first corner: far from the origin the products would cancel.
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return 0.5 * sum;
}

Plane plane_midway(std::span<const glm::dvec3> corners, const glm::dvec3& normal) {
  double lowest = std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::lowest();
  for (const glm::dvec3& corner : corners) {
    const double height = glm::dot(normal, corner);
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  }
  return {normal, 0.5 * (lowest + highest)};
}

double deviation(std::span<const glm::dvec3> corners, const Plane& plane) {
  double largest = 0;
  for (const glm::dvec3& corner : corners)
    largest = std::max(largest, std::abs(glm::dot(plane.normal, corner) - plane.offset));
  return largest;
}

void project(std::span<const glm::dvec3> corners, const glm::dvec3& normal, std::vector<glm::dvec2>& result) {
  const glm::dvec3 size = glm::abs(normal);
  const glm::dvec3 least = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                           : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                : glm::dvec3(0, 0, 1);
  const glm::dvec3 x = glm::normalize(glm::cross(least, normal));
  const glm::dvec3 y = glm::cross(normal, x);
  result.clear();
  for (const glm::dvec3& corner : corners) {
    const glm::dvec3 p = corner - corners[0];
    result.emplace_back(glm::dot(x, p), glm::dot(y, p));
  }
}

double signed_area(std::span<const glm::dvec2> corners) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) sum += cross(corners[0], corners[i], corners[i + 1]);
  return 0.5 * sum;
}

bool is_convex(std::span<const glm::dvec2> corners, double tolerance) {
  const std::size_t count = corners.size();
  if (count < 3) return false;
  if (count == 3) return cross(corners[0], corners[1], corners[2]) > 0;
  // An extreme corner is surely on the hull. From there, keep only left turns (Graham's scan along the outline).
  const auto lowest = std::min_element(corners.begin(), corners.end(), [](const glm::dvec2& a, const glm::dvec2& b) {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
  });
  const auto start = static_cast<std::size_t>(lowest - corners.begin());
  const auto at = [&](std::size_t i) -> const glm::dvec2& { return corners[(start + i) % count]; };
  std::vector<std::size_t> hull{0};
  for (std::size_t i = 1; i <= count; ++i) {
    while (hull.size() >= 2 && cross(at(hull[hull.size() - 2]), at(hull.back()), at(i)) <= 0) hull.pop_back();
    hull.push_back(i);
  }
  if (hull.size() < 4) return false;  // the start stands in it twice
  // Seen from the start, the hull's corners must turn left all the way: else the outline went round more than once.
  for (std::size_t i = 1; i + 2 < hull.size(); ++i)
    if (cross(at(0), at(hull[i]), at(hull[i + 1])) <= 0) return false;
  for (std::size_t i = 0; i + 1 < hull.size(); ++i) {
    const glm::dvec2 from = at(hull[i]);
    const glm::dvec2 edge = at(hull[i + 1]) - from;
    const double length = glm::length(edge);
    double passed = 0;
    for (std::size_t k = hull[i] + 1; k < hull[i + 1]; ++k) {
      const glm::dvec2 p = at(k) - from;
      const double inside = (edge.x * p.y - edge.y * p.x) / length;
      const double along = glm::dot(edge, p) / length;
      // Further along than the last one, or the outline runs back over itself.
      if (std::abs(inside) > tolerance || along < passed - tolerance || along > length + tolerance) return false;
      passed = std::max(passed, along);
    }
  }
  return true;
}

bool is_inside_convex(std::span<const glm::dvec2> corners, const glm::dvec2& point) {
  bool left = false, right = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double side = cross(corners[i], corners[i + 1 < corners.size() ? i + 1 : 0], point);
    left = left || side > 0;
    right = right || side < 0;
    if (left && right) return false;
  }
  return true;
}

EdgeBox smallest_box(std::span<const glm::dvec2> corners) {
  EdgeBox best;
  double best_area = std::numeric_limits<double>::infinity();
  const std::size_t step = (corners.size() + 255) / 256;
  for (std::size_t i = 0; i < corners.size(); i += step) {
    const glm::dvec2 edge = corners[(i + 1) % corners.size()] - corners[i];
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    const glm::dvec2 y = edge / length;
    const glm::dvec2 x(y.y, -y.x);
    glm::dvec2 low(std::numeric_limits<double>::infinity());
    glm::dvec2 high(-std::numeric_limits<double>::infinity());
    for (const glm::dvec2& corner : corners) {
      const glm::dvec2 p(glm::dot(x, corner), glm::dot(y, corner));
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const glm::dvec2 extent = high - low;
    const double area = extent.x * extent.y;
    // Clearly smaller only: the box of a rectangle must not depend on rounding.
    if (area < best_area * (1 - 1e-9)) {
      best_area = area;
      best = {i, y, low, extent};
    }
  }
  return best;
}

}  // namespace foreview
