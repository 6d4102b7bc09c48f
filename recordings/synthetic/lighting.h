#pragma once
#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "foreview/recordings/synthetic/ray_caster.h"
#include "foreview/recordings/synthetic/site.h"
#include "foreview/scene/pose.h"

namespace foreview::synthetic {

/// The light that falls on a face, on a coarse grid over its box in (u, v).
struct LightGrid {
  glm::vec2 low{0}, cells_per_metre{1};
  int across = 2, down = 2;        ///< points, at least 2 along each side
  std::vector<glm::dvec3> points;  ///< part frame, just in front of the face
  glm::dvec3 normal{0, 0, 1};      ///< part frame
  struct Light {
    float ambient = 0;
    std::array<float, kMaxLights> lamps{};
  };
  std::vector<Light> lights;  ///< per point, without what moves; faces that move: whatever the pose gives, filled later
};

/// Soft light of a site: lamps with area, ambient light with occlusion (static things by rays, moving ones as capsules
/// in closed form).
class Lighting {
 public:
  explicit Lighting(const Site& site);

  /// Lays out a face's grid over its corners' (u, v) box, points `step` metres apart at most; for a face that never
  /// moves the light is computed too.
  [[nodiscard]] LightGrid make_grid(std::size_t face, const glm::dvec2& low, const glm::dvec2& high, double step) const;

  /// What changes with time: lamps' brightness and where the moving occluders are.
  struct Moment {
    std::vector<Pose> world_from_part;
    float ambient = 1;
    std::array<float, kMaxLights> lamps{};
    struct Occluder {
      std::uint32_t part;
      glm::vec3 a, b;
      float radius;
    };
    std::vector<Occluder> occluders;  ///< world
    glm::vec3 centre{0};              ///< of a ball around all of them
    float reach = 0;
  };
  [[nodiscard]] Moment moment(double t) const;

  /// Square root of the light (linear RGB) at each point of the grid: display colours are multiplied by it.
  void light_up(std::size_t face, const LightGrid& grid, const Moment& moment, std::vector<glm::vec3>& result) const;

 private:
  [[nodiscard]] LightGrid::Light static_light(const glm::vec3& p, const glm::vec3& normal) const;
  [[nodiscard]] LightGrid::Light open_light(const glm::vec3& p, const glm::vec3& normal) const;

  const Site& site_;
  RayCaster static_things_;
  std::vector<glm::vec3> hemisphere_;  ///< directions, cosine-weighted about +z
};

}  // namespace foreview::synthetic
