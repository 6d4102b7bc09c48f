#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "foreview/scene/polygon_model.h"

namespace foreview {

/// What every polygon of every model must keep, checked with plain definitions and none of the model's own code:
/// planar, counter-clockwise, convex within `tolerance` (distance from an edge's line), neighbours mutual and sorted.
inline void check_invariants(const PolygonModel& model, double planarity = 1e-3, double tolerance = 2e-5) {
  std::size_t not_planar = 0, not_convex = 0, bad_normal = 0, bad_neighbours = 0, repeated = 0, flat = 0;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const Polygon& polygon = model.polygons()[i];
    const auto corners = model.corners_of(i);
    ASSERT_GE(corners.size(), 3U);
    ASSERT_LT(polygon.part, model.parts().size());
    bad_normal += std::abs(glm::length(polygon.normal) - 1) > 1e-9 ? 1 : 0;
    glm::dvec3 area(0);
    double diameter = 0;
    for (const std::uint32_t corner : corners)
      diameter = std::max(diameter, 2 * glm::distance(model.corner(i, 0), model.vertices()[corner]));
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const glm::dvec3 a = model.corner(i, k);
      const glm::dvec3 b = model.corner(i, (k + 1) % corners.size());
      area += glm::cross(a - model.corner(i, 0), b - model.corner(i, 0));
      not_planar += std::abs(glm::dot(polygon.normal, a) - polygon.offset) > planarity * (1 + 1e-6) + 1e-12 ? 1 : 0;
      const glm::dvec3 edge = b - a;
      // The line through a very short edge says nothing about what lies far from it.
      if (glm::length(edge) < 0.01 * diameter) continue;
      const glm::dvec3 inwards = glm::normalize(glm::cross(polygon.normal, edge));
      for (const std::uint32_t other : corners)
        not_convex += glm::dot(inwards, model.vertices()[other] - a) < -100 * tolerance ? 1 : 0;
      const glm::dvec3 c = model.corner(i, (k + 2) % corners.size());
      // A reflex corner may lie off the line between its neighbours by the tolerance only.
      const double turn = glm::dot(polygon.normal, glm::cross(b - a, c - b));
      if (turn < 0) not_convex += -turn / std::max(1e-300, glm::distance(a, c)) > tolerance ? 1 : 0;
    }
    flat += glm::dot(area, polygon.normal) <= 0 ? 1 : 0;
    std::vector<std::uint32_t> sorted(corners.begin(), corners.end());
    std::sort(sorted.begin(), sorted.end());
    repeated += std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end() ? 1 : 0;
    const auto neighbours = model.neighbours_of(i);
    bad_neighbours += !std::is_sorted(neighbours.begin(), neighbours.end()) ? 1 : 0;
    for (const std::uint32_t n : neighbours) {
      const auto back = model.neighbours_of(n);
      bad_neighbours += n == i || !std::binary_search(back.begin(), back.end(), static_cast<std::uint32_t>(i)) ? 1 : 0;
    }
  }
  EXPECT_EQ(not_planar, 0U);
  EXPECT_EQ(not_convex, 0U);
  EXPECT_EQ(bad_normal, 0U);
  EXPECT_EQ(bad_neighbours, 0U);
  EXPECT_EQ(repeated, 0U) << "polygons with the same corner twice";
  EXPECT_EQ(flat, 0U) << "polygons whose normal is not on their front";
}

/// Sum of areas, without the backdrop.
inline double total_area(const PolygonModel& model) {
  double area = 0;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    if (model.polygons()[i].is_backdrop) continue;
    for (std::size_t k = 1; k + 1 < model.corners_of(i).size(); ++k)
      area += 0.5 * glm::dot(model.polygons()[i].normal, glm::cross(model.corner(i, k) - model.corner(i, 0),
                                                                    model.corner(i, k + 1) - model.corner(i, 0)));
  }
  return area;
}

}  // namespace foreview
