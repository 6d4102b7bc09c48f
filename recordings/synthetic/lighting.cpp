#include "foreview/recordings/synthetic/lighting.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "foreview/recordings/synthetic/noise.h"

namespace foreview::synthetic {
namespace {

constexpr float kAmbientReach = 0.9F;  // metres: beyond, nothing dims the ambient light
constexpr int kLampGrid = 3;           // sample points along a lamp's sides

RayCaster caster_of(const Site& site) {
  std::vector<glm::vec3> corners;
  for (std::size_t f = 0; f < site.mesh.faces.size(); ++f) {
    // Lamps do not shade: their light begins on them.
    const bool lamp = site.surfaces[site.faces[f].surface].material == Material::lamp;
    if (lamp || site.part_moves[site.mesh.face_part[f]] != 0) continue;
    const auto& face = site.mesh.faces[f];
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      for (const std::uint32_t corner : {face[0], face[i], face[i + 1]}) {
        corners.emplace_back(site.mesh.vertices[corner]);
      }
    }
  }
  return RayCaster(std::move(corners));
}

/// Nearest points of two segments: their distance, and where on the first (0..1).
struct Approach {
  float distance, fraction;
};
Approach approach(const glm::vec3& p, const glm::vec3& q, const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 d1 = q - p, d2 = b - a, r = p - a;
  const float aa = glm::dot(d1, d1), e = glm::dot(d2, d2), f = glm::dot(d2, r), c = glm::dot(d1, r);
  float s = 0, t = 0;
  if (e < 1e-10F) {
    s = std::clamp(-c / aa, 0.0F, 1.0F);
  } else {
    const float bb = glm::dot(d1, d2), denominator = aa * e - bb * bb;
    s = denominator > 1e-9F ? std::clamp((bb * f - c * e) / denominator, 0.0F, 1.0F) : 0.0F;
    t = (bb * s + f) / e;
    if (t < 0) {
      t = 0;
      s = std::clamp(-c / aa, 0.0F, 1.0F);
    } else if (t > 1) {
      t = 1;
      s = std::clamp((bb - c) / aa, 0.0F, 1.0F);
    }
  }
  return {glm::length((p + d1 * s) - (a + d2 * t)), s};
}

float lamp_radius(const AreaLight& lamp) {
  return static_cast<float>(std::sqrt(glm::length(lamp.half_u) * glm::length(lamp.half_v)));
}

}  // namespace

Lighting::Lighting(const Site& site) : site_(site), static_things_(caster_of(site)) {
  constexpr int kRays = 40;
  for (int i = 0; i < kRays; ++i) {
    const double fraction = (i + 0.5) / kRays, turn = i * std::numbers::pi * (3 - std::sqrt(5.0)) + 0.1;
    const double r = std::sqrt(fraction);
    hemisphere_.emplace_back(r * std::cos(turn), r * std::sin(turn), std::sqrt(1 - fraction));
  }
}

LightGrid::Light Lighting::open_light(const glm::vec3& p, const glm::vec3& normal) const {
  LightGrid::Light result;
  // A light ceiling and walls, a darker floor.
  result.ambient = 0.72F + 0.28F * normal.z;
  for (std::size_t k = 0; k < site_.lights.size(); ++k) {
    const AreaLight& lamp = site_.lights[k];
    for (int i = 0; i < kLampGrid * kLampGrid; ++i) {
      const double u = (i % kLampGrid + 0.5) / kLampGrid * 2 - 1, v = (i / kLampGrid + 0.5) / kLampGrid * 2 - 1;
      const glm::vec3 way = glm::vec3(lamp.centre + u * lamp.half_u + v * lamp.half_v) - p;
      const float distance = std::max(glm::length(way), 0.05F);
      const float facing = std::max(0.0F, glm::dot(way, normal) / distance);
      const float from_lamp = std::max(0.0F, -glm::dot(way, glm::vec3(lamp.direction)) / distance);
      result.lamps[k] += facing * from_lamp / (distance * distance) * static_cast<float>(lamp.intensity) /
                         static_cast<float>(kLampGrid * kLampGrid);
    }
  }
  return result;
}

LightGrid::Light Lighting::static_light(const glm::vec3& p, const glm::vec3& normal) const {
  LightGrid::Light result = open_light(p, normal);
  const glm::vec3 side = std::abs(normal.z) < 0.9F ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
  const glm::vec3 tangent = glm::normalize(glm::cross(side, normal)), other = glm::cross(normal, tangent);
  float open = 0;
  for (const glm::vec3& h : hemisphere_) {
    const glm::vec3 direction = tangent * h.x + other * h.y + normal * h.z;
    const float distance = static_things_.distance(p, direction, kAmbientReach) / kAmbientReach;
    open += std::sqrt(distance);
  }
  result.ambient *= open / static_cast<float>(hemisphere_.size());
  for (std::size_t k = 0; k < site_.lights.size(); ++k) {
    if (result.lamps[k] <= 0) continue;
    const AreaLight& lamp = site_.lights[k];
    int seen = 0;
    for (int i = 0; i < kLampGrid * kLampGrid; ++i) {
      const double u = (i % kLampGrid + 0.5) / kLampGrid * 2 - 1, v = (i / kLampGrid + 0.5) / kLampGrid * 2 - 1;
      const glm::vec3 way = glm::vec3(lamp.centre + u * lamp.half_u + v * lamp.half_v) - p;
      const float distance = glm::length(way);
      seen += static_things_.blocked(p, way / distance, distance - 0.02F) ? 0 : 1;
    }
    result.lamps[k] *= static_cast<float>(seen) / static_cast<float>(kLampGrid * kLampGrid);
  }
  return result;
}

LightGrid Lighting::make_grid(std::size_t face, const glm::dvec2& low, const glm::dvec2& high, double step) const {
  const FaceSurface& look = site_.faces[face];
  const auto& corners = site_.mesh.faces[face];
  const auto vertex = [&](std::size_t i) { return site_.mesh.vertices[corners[i % corners.size()]]; };
  LightGrid grid;
  const glm::dvec2 extent = high - low;
  grid.across = std::clamp(static_cast<int>(std::ceil(extent.x / step)) + 1, 2, 64);
  grid.down = std::clamp(static_cast<int>(std::ceil(extent.y / step)) + 1, 2, 64);
  grid.low = glm::vec2(low);
  grid.cells_per_metre = glm::vec2((grid.across - 1) / extent.x, (grid.down - 1) / extent.y);
  grid.normal = glm::normalize(glm::cross(vertex(1) - vertex(0), vertex(2) - vertex(0)));
  for (int j = 0; j < grid.down; ++j) {
    for (int i = 0; i < grid.across; ++i) {
      const glm::dvec2 uv = low + extent * glm::dvec2(i / (grid.across - 1.0), j / (grid.down - 1.0));
      glm::dvec3 p = look.origin + uv.x * look.u_axis + uv.y * look.v_axis;
      p += grid.normal * glm::dot(grid.normal, vertex(0) - p);
      // Points on the rim are pulled inside, lest they lie in the neighbouring wall.
      constexpr double kInset = 0.004;
      for (int round = 0; round < 3; ++round) {
        for (std::size_t e = 0; e < corners.size(); ++e) {
          const glm::dvec3 inward = glm::normalize(glm::cross(grid.normal, vertex(e + 1) - vertex(e)));
          const double inside = glm::dot(inward, p - vertex(e));
          if (inside < kInset) p += inward * (kInset - inside);
        }
      }
      grid.points.push_back(p + grid.normal * 0.003);
    }
  }
  if (site_.part_moves[site_.mesh.face_part[face]] == 0) {
    for (const glm::dvec3& p : grid.points) {
      grid.lights.push_back(static_light(glm::vec3(p), glm::vec3(grid.normal)));
    }
  }
  return grid;
}

Lighting::Moment Lighting::moment(double t) const {
  Moment now;
  now.world_from_part = site_.world_from_part(t);
  now.ambient = static_cast<float>(site_.ambient_over_time(t));
  for (std::size_t k = 0; k < site_.lights.size(); ++k) {
    now.lamps[k] = static_cast<float>(site_.lights[k].over_time(t));
  }
  glm::vec3 low(1e9F), high(-1e9F);
  for (const Capsule& c : site_.moving_occluders) {
    const Pose& pose = now.world_from_part[c.part];
    now.occluders.push_back({c.part, glm::vec3(pose * c.a), glm::vec3(pose * c.b), static_cast<float>(c.radius)});
    low = glm::min(low, glm::min(now.occluders.back().a, now.occluders.back().b));
    high = glm::max(high, glm::max(now.occluders.back().a, now.occluders.back().b));
  }
  now.centre = (low + high) * 0.5F;
  now.reach = now.occluders.empty() ? -1.0F : glm::length(high - low) * 0.5F + kAmbientReach;
  return now;
}

void Lighting::light_up(std::size_t face, const LightGrid& grid, const Moment& moment,
                        std::vector<glm::vec3>& result) const {
  const std::uint32_t part = site_.mesh.face_part[face];
  const Pose& pose = moment.world_from_part[part];
  const glm::vec3 normal(pose.rotate(grid.normal));
  const bool moves = site_.part_moves[part] != 0;
  if (site_.surfaces[site_.faces[face].surface].material == Material::lamp) {
    result.assign(grid.points.size(), glm::vec3(std::sqrt(1.6F * moment.lamps[0])));
    return;
  }
  for (std::size_t i = 0; i < grid.points.size(); ++i) {
    const glm::vec3 p(moves ? pose * grid.points[i] : grid.points[i]);
    LightGrid::Light light = moves ? open_light(p, normal) : grid.lights[i];
    if (glm::length(p - moment.centre) < moment.reach) {
      for (const Moment::Occluder& o : moment.occluders) {
        if (o.part == part) continue;
        const Approach near = approach(p, p + normal * 1e-3F, o.a, o.b);
        const float d = std::max(near.distance, o.radius);
        const glm::vec3 middle = o.a + (o.b - o.a) * std::clamp(glm::dot(p - o.a, o.b - o.a) /
                                                                    std::max(glm::dot(o.b - o.a, o.b - o.a), 1e-9F),
                                                                0.0F, 1.0F);
        const float above = std::clamp(glm::dot(normal, middle - p) / std::max(d, 1e-6F) * 0.8F + 0.2F, 0.0F, 1.0F);
        const float fade = 1 - smooth(0.6F * kAmbientReach, kAmbientReach, near.distance);
        light.ambient *= 1 - 0.75F * above * (o.radius / d) * (o.radius / d) * fade;
        for (std::size_t k = 0; k < site_.lights.size(); ++k) {
          const glm::vec3 lamp(site_.lights[k].centre);
          const Approach way = approach(p, lamp, o.a, o.b);
          const float cone = std::max(lamp_radius(site_.lights[k]) * way.fraction, 0.004F);
          if (way.distance > o.radius + cone) continue;
          const float share = std::min(1.0F, o.radius / cone);
          const float blocked = 1 - smooth(o.radius - cone * share, o.radius + cone, way.distance);
          light.lamps[k] *= 1 - share * blocked;
        }
      }
    }
    glm::vec3 sum = site_.ambient * (moment.ambient * light.ambient);
    for (std::size_t k = 0; k < site_.lights.size(); ++k) {
      sum += site_.lights[k].colour * (moment.lamps[k] * light.lamps[k]);
    }
    result.push_back(glm::sqrt(sum));
  }
}

}  // namespace foreview::synthetic
