#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

// Plane geometry of one polygon: what cleaning, splitting, merging and texel maps have in common. Metres.

namespace foreview {

struct Plane {
  glm::dvec3 normal{0, 0, 1};  ///< unit length
  double offset = 0;           ///< dot(normal, p) == offset on the plane
};

/// The polygon's vector area by Newell's method: normal to the plane that fits best, length = area. Zero for an outline
/// that encloses nothing.
[[nodiscard]] glm::dvec3 vector_area(std::span<const glm::dvec3> corners);
/// The plane with this normal (unit length) midway between the corners that are furthest apart along it.
[[nodiscard]] Plane plane_midway(std::span<const glm::dvec3> corners, const glm::dvec3& normal);
/// Largest distance of a corner from the plane.
[[nodiscard]] double deviation(std::span<const glm::dvec3> corners, const Plane& plane);
/// Coordinates along two fixed unit axes in the plane, right-handed with the normal, relative to the first corner.
void project(std::span<const glm::dvec3> corners, const glm::dvec3& normal, std::vector<glm::dvec2>& result);

/// Twice the signed area of the triangle a b c; positive counter-clockwise.
[[nodiscard]] inline double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}
[[nodiscard]] double signed_area(std::span<const glm::dvec2> corners);
/// True for a counter-clockwise outline that goes round once and nowhere lies further than `tolerance` inside its
/// convex hull: a corner that rounding put a hair off a straight edge does not make a polygon concave.
[[nodiscard]] bool is_convex(std::span<const glm::dvec2> corners, double tolerance);
/// Whether a point lies in a convex outline or on it, whichever way round it goes.
[[nodiscard]] bool is_inside_convex(std::span<const glm::dvec2> corners, const glm::dvec2& point);

/// The smallest-area box with one side along one of the outline's edges. Angles are tried as spec 6 says, first wins
/// ties. `edge` is the edge's first corner; sides along (x, y) with y along the edge, x to its right.
struct EdgeBox {
  std::size_t edge = 0;
  glm::dvec2 y_axis{0, 1};  ///< unit length, along the edge
  glm::dvec2 lowest{0, 0};  ///< smallest coordinates along (x, y)
  glm::dvec2 extent{0, 0};
};
[[nodiscard]] EdgeBox smallest_box(std::span<const glm::dvec2> corners);

}  // namespace foreview
