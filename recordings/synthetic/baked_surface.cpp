#include "foreview/recordings/synthetic/baked_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "foreview/recordings/synthetic/surface.h"

namespace foreview::synthetic {
namespace {

constexpr int kMargin = 3;  // texels
constexpr std::size_t kLevels = 6;

}  // namespace

void BakedSurface::bake(const Surface& surface, const FaceSurface& face, const glm::dvec2& low, const glm::dvec2& high,
                        double texels_per_metre) {
  density_ = static_cast<float>(texels_per_metre);
  low_ = glm::vec2(low - kMargin / texels_per_metre);
  Level base;
  base.width = static_cast<int>(std::ceil((high.x - low.x) * texels_per_metre)) + 2 * kMargin;
  base.height = static_cast<int>(std::ceil((high.y - low.y) * texels_per_metre)) + 2 * kMargin;
  base.texels.reserve(static_cast<std::size_t>(base.width) * static_cast<std::size_t>(base.height));
  const glm::vec2 size(face.size);
  for (int y = 0; y < base.height; ++y) {
    for (int x = 0; x < base.width; ++x) {
      const glm::vec2 uv = low_ + glm::vec2(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F) / density_;
      const glm::vec3 c = surface_colour(surface, uv, size) * 255.0F + 0.5F;
      base.texels.push_back(
          {static_cast<std::uint8_t>(c.r), static_cast<std::uint8_t>(c.g), static_cast<std::uint8_t>(c.b), 0});
    }
  }
  levels_.clear();
  levels_.push_back(std::move(base));
  while (levels_.size() < kLevels && (levels_.back().width > 1 || levels_.back().height > 1)) {
    const Level& fine = levels_.back();
    Level coarse;
    coarse.width = (fine.width + 1) / 2;
    coarse.height = (fine.height + 1) / 2;
    coarse.texels.reserve(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        std::array<int, 3> sum{};
        for (int k = 0; k < 4; ++k) {
          const int fx = std::min(2 * x + (k & 1), fine.width - 1), fy = std::min(2 * y + (k >> 1), fine.height - 1);
          const auto& texel = fine.texels[static_cast<std::size_t>(fy) * static_cast<std::size_t>(fine.width) +
                                          static_cast<std::size_t>(fx)];
          for (std::size_t c = 0; c < 3; ++c) sum[c] += texel[c];
        }
        coarse.texels.push_back({static_cast<std::uint8_t>((sum[0] + 2) / 4),
                                 static_cast<std::uint8_t>((sum[1] + 2) / 4),
                                 static_cast<std::uint8_t>((sum[2] + 2) / 4), 0});
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

glm::vec3 BakedSurface::bilinear(std::size_t level, const glm::vec2& texel) const {
  const Level& image = levels_[level];
  const float scale = 1.0F / static_cast<float>(1U << level);
  const float x = std::clamp(texel.x * scale - 0.5F, 0.0F, static_cast<float>(image.width - 1));
  const float y = std::clamp(texel.y * scale - 0.5F, 0.0F, static_cast<float>(image.height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const float tx = x - static_cast<float>(x0), ty = y - static_cast<float>(y0);
  const auto at = [&](int i, int j) {
    const auto& t =
        image.texels[static_cast<std::size_t>(j) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(i)];
    return glm::vec3(t[0], t[1], t[2]);
  };
  const glm::vec3 upper = at(x0, y0) * (1 - tx) + at(x1, y0) * tx;
  const glm::vec3 lower = at(x0, y1) * (1 - tx) + at(x1, y1) * tx;
  return upper * (1 - ty) + lower * ty;
}

glm::vec3 BakedSurface::trilinear(float level, const glm::vec2& texel) const {
  const float top = static_cast<float>(levels_.size() - 1);
  if (level <= 0) return bilinear(0, texel);
  if (level >= top) return bilinear(levels_.size() - 1, texel);
  const auto fine = static_cast<std::size_t>(level);
  const float t = level - static_cast<float>(fine);
  return bilinear(fine, texel) * (1 - t) + bilinear(fine + 1, texel) * t;
}

glm::vec3 BakedSurface::colour(const glm::vec2& uv, const glm::vec2& across, const glm::vec2& down) const {
  const glm::vec2 texel = (uv - low_) * density_;
  const float a = glm::dot(across, across), d = glm::dot(down, down);
  const float longer = std::sqrt(std::max(a, d)) * density_, shorter = std::sqrt(std::min(a, d)) * density_;
  // Slanted faces: several taps along the longer side, so that the shorter one stays sharp.
  constexpr float kMaxTaps = 6;
  const float taps = std::clamp(std::ceil(longer / std::max(shorter, 1.0F) - 0.2F), 1.0F, kMaxTaps);
  const float level = std::log2(std::max(std::max(shorter, longer / taps), 1e-6F)) - 0.3F;
  if (taps < 1.5F) return trilinear(level, texel) * (1.0F / 255);
  const glm::vec2 step = (a > d ? across : down) * (density_ / taps);
  glm::vec3 sum{0};
  for (float i = 0.5F - taps / 2; i < taps / 2; i += 1.0F) sum += trilinear(level, texel + step * i);
  return sum * (1.0F / (255 * taps));
}

}  // namespace foreview::synthetic
