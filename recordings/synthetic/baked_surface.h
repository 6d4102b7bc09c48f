#pragma once
#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "foreview/recordings/synthetic/site.h"

namespace foreview::synthetic {

/// A face's surface, evaluated once on a grid finer than its detail, with averaged coarser levels.
class BakedSurface {
 public:
  /// Covers u and v from `low` to `high` (metres, FaceSurface's coordinates) and a margin. 600 texels/m hold all that
  /// surface_colour() draws; far scenery needs fewer.
  void bake(const Surface& surface, const FaceSurface& face, const glm::dvec2& low, const glm::dvec2& high,
            double texels_per_metre);

  /// Display colour (RGB, 0..1) around (u, v), averaged over a pixel whose sides span `across` and `down` in (u, v).
  [[nodiscard]] glm::vec3 colour(const glm::vec2& uv, const glm::vec2& across, const glm::vec2& down) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::array<std::uint8_t, 4>> texels;  ///< RGB and nothing
  };
  [[nodiscard]] glm::vec3 bilinear(std::size_t level, const glm::vec2& texel) const;
  [[nodiscard]] glm::vec3 trilinear(float level, const glm::vec2& texel) const;

  glm::vec2 low_{0};
  float density_ = 1;  ///< texels per metre
  std::vector<Level> levels_;
};

}  // namespace foreview::synthetic
