#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "foreview/recordings/synthetic/site_builder.h"

namespace foreview::synthetic {
namespace {

const glm::dvec3 kMiddle{0, 0, 1.3};  // metres: where the object stands in its hall

/// A hall around a single object: lights, and scenery that the model does not hold.
void add_hall(Site& site, SiteBuilder& builder, std::uint32_t part) {
  site.model_faces = site.mesh.faces.size();
  site.model_vertices = site.mesh.vertices.size();
  const glm::dvec3 size{14, 14, 6};
  SiteBuilder::BoxSurfaces walls(
      builder.surface({Material::brick, {0.62F, 0.36F, 0.27F}, {0.78F, 0.75F, 0.70F}, 0, ""}));
  walls.left = walls.right = builder.surface({Material::wood, {0.70F, 0.56F, 0.40F}, {0.42F, 0.30F, 0.20F}, 0, ""});
  walls.bottom = builder.surface({Material::floor, {0.60F, 0.57F, 0.52F}, {0.30F, 0.33F, 0.36F}, 0, ""});
  walls.top = builder.surface({Material::ceiling, {0.85F, 0.85F, 0.84F}, {0.45F, 0.46F, 0.48F}, 0, ""});
  // Tiles only keep the renderer's baked surfaces small.
  builder.box(part, placed({0, 0, size.z / 2}), size, walls, {7, 7, 3}, true);
  for (int i = 0; i < 10; ++i) {
    const double angle = i * 0.63;
    const glm::dvec3 foot{5.2 * std::cos(angle), 5.2 * std::sin(angle), 0};
    const glm::dvec3 extent{0.9 + 0.1 * (i % 4), 0.7, 0.8 + 0.35 * (i % 3)};
    const std::uint32_t look =
        i % 2 == 0 ? builder.surface({Material::carton, {0.64F, 0.48F, 0.31F}, {0.15F, 0.15F, 0.15F}, 0, "STORE"})
                   : builder.surface({Material::poster, {0.25F, 0.45F, 0.55F}, {0.85F, 0.75F, 0.45F}, 0, "HALL 3"});
    builder.box(part, placed(foot + glm::dvec3(0, 0, extent.z / 2), angle), extent, look);
  }
  const auto steady = [](double) { return 1.0; };
  site.lights.push_back({{2.5, -1.5, 5.8}, {1.2, 0, 0}, {0, 1.2, 0}, {0, 0, -1}, {1.0F, 0.97F, 0.92F}, 9.0, steady});
  site.lights.push_back({{-3.0, 2.0, 5.8}, {1.2, 0, 0}, {0, 1.2, 0}, {0, 0, -1}, {0.92F, 0.96F, 1.0F}, 6.0, steady});
  site.ambient = {0.42F, 0.42F, 0.43F};
  site.ambient_over_time = [](double t) { return 1 + 0.06 * std::sin(1.3 * t); };
  site.closed_room = false;
}

CameraModel single_camera() {
  CameraModel camera;
  camera.width = 751;
  camera.height = 570;
  camera.focal_length = {640.2, 639.4};
  camera.principal_point = {376.1, 284.2};
  camera.distortion_model = DistortionModel::plumb_bob;
  camera.distortion = {-0.105, 0.022, 0.0003, -0.0005, 0, 0, 0, 0};
  return camera;
}

/// Around the middle: azimuth and elevation in radians, distance in metres.
Pose orbiting(double azimuth, double elevation, double distance) {
  const glm::dvec3 way{std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                       std::sin(elevation)};
  return looking_at(kMiddle + distance * way, kMiddle, {0, 0, 1});
}

}  // namespace

Site make_object_site() {
  Site site;
  site.name = "object";
  SiteBuilder builder(site);
  const std::uint32_t part = builder.part("object", false);
  const std::uint32_t steel = builder.surface({Material::metal, {0.55F, 0.57F, 0.60F}, {0.15F, 0.15F, 0.16F}, 0, ""});
  const std::uint32_t plate = builder.surface({Material::breadboard, {0.24F, 0.26F, 0.30F}, {0.6F, 0.6F, 0.6F}, 0, ""});
  const std::uint32_t body =
      builder.surface({Material::label, {0.20F, 0.45F, 0.42F}, {0.85F, 0.55F, 0.15F}, 0, "PUMP-3"});
  const std::uint32_t paint = builder.surface({Material::paint, {0.80F, 0.36F, 0.16F}, {0, 0, 0}, 0, ""});
  const std::uint32_t stripe = builder.surface({Material::hazard, {0.93F, 0.76F, 0.12F}, {0.1F, 0.1F, 0.1F}, 0, ""});
  const std::uint32_t code = builder.surface({Material::marker, {0.94F, 0.93F, 0.9F}, {0.08F, 0.08F, 0.09F}, 0, ""});
  const std::uint32_t box =
      builder.surface({Material::poster, {0.30F, 0.42F, 0.62F}, {0.85F, 0.8F, 0.65F}, 0, "DRIVE"});
  builder.begin_object();
  builder.box(part, placed(kMiddle + glm::dvec3(0, 0, -0.32)), {0.84, 0.60, 0.06}, {stripe, plate}, {3, 3, 1});
  builder.lathe(
      part, placed(kMiddle + glm::dvec3(-0.12, 0, 0)),
      {{0.22, -0.29, stripe}, {0.22, -0.22, body}, {0.20, 0.10, paint}, {0.12, 0.22, steel}, {0.12, 0.30, steel}}, 16,
      steel, code);
  builder.box(part, placed(kMiddle + glm::dvec3(0.25, 0, -0.16), 0.0), {0.22, 0.34, 0.26}, {box, code});
  builder.box(part, placed(kMiddle + glm::dvec3(0.13, 0.06, -0.17)), {0.12, 0.06, 0.06}, steel);
  builder.box(part, placed(kMiddle + glm::dvec3(0.13, -0.06, -0.17)), {0.12, 0.06, 0.06}, steel);
  // The flywheel, a prism of 23 sides lying on its side.
  const Pose sideways{glm::angleAxis(std::numbers::pi / 2, glm::dvec3(0, 1, 0)), kMiddle + glm::dvec3(0.37, 0, -0.12)};
  builder.prism(part, sideways, 0.16, 0, 0.07, 23, stripe, code);
  builder.end_object();
  assert(site.mesh.faces.size() == 139);  // spec 12, table 7.3
  add_hall(site, builder, part);
  site.cameras = {single_camera()};
  site.instants = 100;
  // A third of the way around: much of the object is never seen.
  site.world_from_camera = [](std::size_t, double t) {
    return orbiting(-0.5 + 1.1 * std::sin(1.5 * t), 0.35 + 0.25 * std::sin(2.3 * t + 0.5),
                    1.35 + 0.2 * std::sin(1.9 * t));
  };
  site.world_from_part = [](double) { return std::vector<Pose>(1); };
  return site;
}

Site make_cube_site() {
  Site site;
  site.name = "cube";
  SiteBuilder builder(site);
  const std::uint32_t part = builder.part("cube", false);
  SiteBuilder::BoxSurfaces sides(0);
  sides.front = builder.surface({Material::poster, {0.20F, 0.40F, 0.62F}, {0.88F, 0.82F, 0.60F}, 0, "ONE"});
  sides.back = builder.surface({Material::carton, {0.70F, 0.52F, 0.33F}, {0.15F, 0.12F, 0.12F}, 0, "TWO"});
  sides.left = builder.surface({Material::marker, {0.94F, 0.93F, 0.9F}, {0.10F, 0.16F, 0.30F}, 0, ""});
  sides.right = builder.surface({Material::poster, {0.62F, 0.25F, 0.20F}, {0.85F, 0.85F, 0.80F}, 0, "FOUR"});
  sides.top = builder.surface({Material::cloth, {0.82F, 0.82F, 0.78F}, {0.25F, 0.45F, 0.35F}, 0, ""});
  sides.bottom = builder.surface({Material::brick, {0.68F, 0.40F, 0.28F}, {0.80F, 0.77F, 0.72F}, 0, ""});
  builder.begin_object();
  builder.box(part, placed(kMiddle, 0.3), glm::dvec3(0.5), sides);
  builder.end_object();
  add_hall(site, builder, part);
  site.cameras = {single_camera()};
  site.instants = 80;
  // Twice around, from above and from below, so that every side is seen almost wholly.
  site.world_from_camera = [](std::size_t, double t) {
    return orbiting(3.9 * t, 0.75 * std::sin(1.95 * t), 1.25 + 0.1 * std::sin(3 * t));
  };
  site.world_from_part = [](double) { return std::vector<Pose>(1); };
  return site;
}

}  // namespace foreview::synthetic
