#include "foreview/scene/ray_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

namespace foreview {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Two parts of random triangles.
RawMesh random_mesh(std::mt19937& random, std::size_t triangles) {
  std::uniform_real_distribution<double> coordinate(-1, 1), size(-0.2, 0.2);
  RawMesh mesh;
  mesh.part_names = {"still", "moving"};
  for (std::size_t i = 0; i < triangles; ++i) {
    const glm::dvec3 middle(coordinate(random), coordinate(random), coordinate(random));
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices.push_back(middle + glm::dvec3(size(random), size(random), size(random)));
    }
    mesh.faces.push_back({first, first + 1, first + 2});
    mesh.face_part.push_back(static_cast<std::uint32_t>(i % 2));
  }
  return mesh;
}

/// The plainest way: every polygon's plane, and which side of every edge.
std::optional<RayCaster::Hit> nearest_of_all(const PolygonModel& model, const glm::dvec3& origin,
                                             const glm::dvec3& direction, std::span<const Pose> world_from_part) {
  std::optional<RayCaster::Hit> nearest;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const Polygon& polygon = model.polygons()[i];
    if (polygon.is_backdrop) continue;
    const Pose part_from_world = world_from_part[polygon.part].inverse();
    const glm::dvec3 from = part_from_world * origin, along = part_from_world.rotate(direction);
    const double s = (polygon.offset - glm::dot(polygon.normal, from)) / glm::dot(polygon.normal, along);
    if (!(s > 0) || (nearest && s >= nearest->distance)) continue;
    bool inside = true;
    for (std::size_t c = 0; c < polygon.corner_count; ++c) {
      const glm::dvec3 &a = model.corner(i, c), &b = model.corner(i, (c + 1) % polygon.corner_count);
      inside = inside && glm::dot(glm::cross(b - a, from + s * along - a), polygon.normal) >= 0;
    }
    if (inside) nearest = RayCaster::Hit{static_cast<std::uint32_t>(i), s};
  }
  return nearest;
}

TEST(RayCaster, MeetsWhatEveryPolygonTriedInTurnSays) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  ImportOptions options;
  options.merge_coplanar = false;
  const PolygonModel model = build_polygon_model(random_mesh(random, 400), options);
  const RayCaster caster(model);
  std::vector<Pose> world_from_part(model.parts().size());
  world_from_part[1] = {glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)), {0.3, -0.2, 0.1}};
  std::size_t met = 0;
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 origin(coordinate(random), coordinate(random), coordinate(random));
    glm::dvec3 direction(coordinate(random), coordinate(random), coordinate(random));
    if (i % 4 == 0) direction[i / 4 % 3] = 0;
    const auto expected = nearest_of_all(model, origin, direction, world_from_part);
    const auto actual = caster.nearest(origin, direction, world_from_part, kInfinity);
    ASSERT_EQ(actual.has_value(), expected.has_value()) << i;
    if (!actual) continue;
    ++met;
    EXPECT_EQ(actual->polygon, expected->polygon) << i;
    EXPECT_NEAR(actual->distance, expected->distance, 1e-9) << i;
    // A limit in front of it.
    const auto nearer = caster.nearest(origin, direction, world_from_part, 0.99 * actual->distance);
    EXPECT_FALSE(nearer.has_value()) << i;
  }
  EXPECT_GT(met, 300U);
}

TEST(RayCaster, MeetsNoBackdrop) {
  std::mt19937 random(7);
  const PolygonModel model = build_polygon_model(random_mesh(random, 10), {});
  const std::vector<Pose> world_from_part(model.parts().size());
  EXPECT_FALSE(RayCaster(model).nearest({0, 0, 5}, {0, 0, 1}, world_from_part, kInfinity));
}

}  // namespace
}  // namespace foreview
