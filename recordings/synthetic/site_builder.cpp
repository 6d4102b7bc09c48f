#include "foreview/recordings/synthetic/site_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace foreview::synthetic {

Pose placed(const glm::dvec3& position, double yaw) {
  return {glm::angleAxis(yaw, glm::dvec3(0, 0, 1)), position};
}

std::uint32_t SiteBuilder::part(const std::string& name, bool moves) {
  site_.mesh.part_names.push_back(name);
  site_.part_moves.push_back(moves ? 1 : 0);
  return static_cast<std::uint32_t>(site_.mesh.part_names.size() - 1);
}

std::uint32_t SiteBuilder::surface(const Surface& surface) {
  site_.surfaces.push_back(surface);
  site_.surfaces.back().seed += static_cast<std::uint32_t>(site_.surfaces.size()) * 7919U;
  return static_cast<std::uint32_t>(site_.surfaces.size() - 1);
}

void SiteBuilder::begin_object() {
  object_ = objects_++;
}

void SiteBuilder::end_object() {
  object_ = -1;
}

std::uint32_t SiteBuilder::add_vertex(const glm::dvec3& p) {
  site_.mesh.vertices.push_back(p);
  return static_cast<std::uint32_t>(site_.mesh.vertices.size() - 1);
}

void SiteBuilder::add_face(std::uint32_t part, std::vector<std::uint32_t> corners, const FaceSurface& look) {
  site_.mesh.faces.push_back(std::move(corners));
  site_.mesh.face_part.push_back(part);
  site_.faces.push_back(look);
  site_.faces.back().free_object = object_;
}

void SiteBuilder::box(std::uint32_t part, const Pose& part_from_box, const glm::dvec3& size,
                      const BoxSurfaces& surfaces, const glm::ivec3& divisions, bool inward) {
  std::map<std::tuple<int, int, int>, std::uint32_t> vertices;  // by place in the grid: tiles share corners
  const auto vertex = [&](const glm::ivec3& at) {
    const auto [place, is_new] = vertices.try_emplace({at.x, at.y, at.z}, 0U);
    if (is_new) place->second = add_vertex(part_from_box * ((glm::dvec3(at) / glm::dvec3(divisions) - 0.5) * size));
    return place->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      glm::dvec3 outward{0};
      outward[axis] = sign;
      const glm::dvec3 normal = inward ? -outward : outward;
      // Up is z on walls and y on floors, so that print stands upright.
      const glm::dvec3 up = axis == 2 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
      const glm::dvec3 right = glm::cross(up, normal);
      const int up_axis = axis == 2 ? 1 : 2;
      const int right_axis = 3 - axis - up_axis;
      const bool mirrored = right[right_axis] < 0;
      const glm::dvec2 side{size[right_axis], size[up_axis]};
      const glm::dvec3 lower_left = 0.5 * (outward * size[axis] - right * side.x - up * side.y);
      const std::uint32_t look = axis == 0   ? (sign < 0 ? surfaces.left : surfaces.right)
                                 : axis == 1 ? (sign < 0 ? surfaces.front : surfaces.back)
                                             : (sign < 0 ? surfaces.bottom : surfaces.top);
      const FaceSurface face{
          look, part_from_box * lower_left, part_from_box.rotate(right), part_from_box.rotate(up), side, -1};
      for (int j = 0; j < divisions[up_axis]; ++j) {
        for (int i = 0; i < divisions[right_axis]; ++i) {
          const auto corner = [&](int along_right, int along_up) {
            glm::ivec3 at{0};
            at[axis] = sign < 0 ? 0 : divisions[axis];
            at[right_axis] = mirrored ? divisions[right_axis] - along_right : along_right;
            at[up_axis] = along_up;
            return vertex(at);
          };
          add_face(part, {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)}, face);
        }
      }
    }
  }
}

void SiteBuilder::lathe(std::uint32_t part, const Pose& part_from_solid, const std::vector<Ring>& rings, int sides,
                        std::uint32_t lower_lid, std::uint32_t upper_lid) {
  const auto count = static_cast<std::size_t>(sides);
  const double step = 2 * std::numbers::pi / sides;
  const auto point = [&](const Ring& ring, int i) {
    return glm::dvec3(ring.radius * std::cos(i * step), ring.radius * std::sin(i * step), ring.height);
  };
  std::vector<std::vector<std::uint32_t>> rims;
  for (const Ring& ring : rings) {
    std::vector<std::uint32_t> rim;
    for (int i = 0; i < sides; ++i) rim.push_back(add_vertex(part_from_solid * point(ring, i)));
    rims.push_back(std::move(rim));
  }
  for (std::size_t k = 0; k + 1 < rings.size(); ++k) {
    const double edge = 2 * std::max(rings[k].radius, rings[k + 1].radius) * std::sin(step / 2);
    const double slant =
        std::hypot(rings[k + 1].height - rings[k].height, (rings[k + 1].radius - rings[k].radius) * std::cos(step / 2));
    for (int i = 0; i < sides; ++i) {
      const glm::dvec3 a = point(rings[k], i), b = point(rings[k], i + 1), d = point(rings[k + 1], i),
                       c = point(rings[k + 1], i + 1);
      const glm::dvec3 right = glm::normalize(rings[k].radius >= rings[k + 1].radius ? b - a : c - d);
      const glm::dvec3 up = glm::normalize((c + d) - (a + b));
      // Print runs on from face to face.
      const glm::dvec3 origin = 0.5 * (a + b) - right * (edge * (i + 0.5));
      FaceSurface face{rings[k].surface,           part_from_solid * origin, part_from_solid.rotate(right),
                       part_from_solid.rotate(up), {edge * sides, slant},    -1};
      const auto here = static_cast<std::size_t>(i), next = (here + 1) % count;
      add_face(part, {rims[k][here], rims[k][next], rims[k + 1][next], rims[k + 1][here]}, face);
    }
  }
  for (const bool upper : {false, true}) {
    const Ring& ring = upper ? rings.back() : rings.front();
    const glm::dvec3 corner{-ring.radius, upper ? -ring.radius : ring.radius, ring.height};
    FaceSurface face{upper ? upper_lid : lower_lid,      part_from_solid * corner,
                     part_from_solid.rotate({1, 0, 0}),  part_from_solid.rotate({0, upper ? 1.0 : -1.0, 0}),
                     {2 * ring.radius, 2 * ring.radius}, -1};
    std::vector<std::uint32_t> rim = upper ? rims.back() : rims.front();
    if (!upper) std::reverse(rim.begin(), rim.end());
    add_face(part, std::move(rim), face);
  }
}

void SiteBuilder::prism(std::uint32_t part, const Pose& part_from_solid, double radius, double from, double to,
                        int sides, std::uint32_t wall, std::uint32_t lid) {
  lathe(part, part_from_solid, {{radius, from, wall}, {radius, to, wall}}, sides, lid, lid);
}

}  // namespace foreview::synthetic
