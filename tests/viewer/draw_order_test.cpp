#include "foreview/viewer/draw_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace foreview {
namespace {

/// Triangles and squares anywhere in a box, in two parts.
PolygonModel scattered() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-5, 5), size(0.05, 0.8);
  RawMesh mesh;
  mesh.part_names = {"still", "moving"};
  for (std::uint32_t i = 0; i < 300; ++i) {
    const glm::dvec3 at(place(random), place(random), place(random));
    const double s = size(random);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {at, at + glm::dvec3(s, 0, 0), at + glm::dvec3(s, s, 0)});
    mesh.faces.push_back({first, first + 1, first + 2});
    if (i % 2 == 0) {
      mesh.vertices.push_back(at + glm::dvec3(0, s, 0));
      mesh.faces.back().push_back(first + 3);
    }
    mesh.face_part.push_back(i % 3 == 0 ? 1 : 0);
  }
  ImportOptions options;
  options.backdrop = false;
  options.merge_coplanar = false;
  return build_polygon_model(mesh, options);
}

TEST(DrawOrder, AllTrianglesNearestFirst) {
  const PolygonModel model = scattered();
  const ViewGeometry geometry(model, lay_out_charts(model, {}));
  DrawOrder order(geometry);
  std::vector<Pose> parts(2);
  for (const Pose& eye : {looking_at({0, -9, 2}, {0, 0, 0}, {0, 0, 1}), looking_at({8, 1, 1}, {0, 0, 0}, {0, 0, 1}),
                          looking_at({0, 0, 0}, {1, 1, 0}, {0, 0, 1})}) {
    parts[1].translation += glm::dvec3(0.5, 0.2, -0.1);
    const auto sorted = order.front_to_back(eye, parts);
    // The same triangles, each whole.
    const auto triangles_of = [](auto indices) {
      std::map<std::array<std::uint32_t, 3>, int> count;
      for (std::size_t i = 0; i + 2 < indices.size(); i += 3) ++count[{indices[i], indices[i + 1], indices[i + 2]}];
      return count;
    };
    ASSERT_EQ(triangles_of(sorted), triangles_of(std::span<const std::uint32_t>(geometry.triangles)));
    // Nothing comes much before what is nearer: 2^(1/8) is a bucket, a radius at most what a ball is too large.
    double furthest = 0;
    for (std::size_t i = 0; i < sorted.size(); i += 3) {
      const std::uint32_t polygon = geometry.vertices[sorted[i]].polygon;
      double nearest = std::numeric_limits<double>::infinity(), size = 0;
      for (std::size_t k = 0; k < model.corners_of(polygon).size(); ++k) {
        const glm::dvec3 p = eye.inverse() * (parts[model.polygons()[polygon].part] * model.corner(polygon, k));
        nearest = std::min(nearest, p.z);
        size = std::max(size, glm::distance(model.corner(polygon, k), model.corner(polygon, 0)));
      }
      if (nearest < 0) continue;
      EXPECT_GT(nearest + size, furthest / 1.1) << i;
      furthest = std::max(furthest, nearest - size);
    }
    EXPECT_GT(furthest, 3);
  }
}

}  // namespace
}  // namespace foreview
