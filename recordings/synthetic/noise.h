#pragma once
#include <cmath>
#include <cstdint>

namespace foreview::synthetic {

/// A hash with good avalanche (the finaliser of MurmurHash3): the generator's only source of chance, so that the same
/// options give the same bytes whatever the order of evaluation.
inline std::uint32_t mix_bits(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x85ebca6bU;
  h ^= h >> 13;
  h *= 0xc2b2ae35U;
  h ^= h >> 16;
  return h;
}

inline std::uint32_t hash_cell(int x, int y, std::uint32_t seed) {
  return mix_bits(static_cast<std::uint32_t>(x) * 0x9e3779b1U ^
                  mix_bits(static_cast<std::uint32_t>(y) * 0x85ebca77U ^ seed * 0xc2b2ae3dU));
}

/// 0..1 for a cell of a grid.
inline float chance(int x, int y, std::uint32_t seed) {
  return static_cast<float>(hash_cell(x, y, seed) >> 8) * (1.0F / 16777216.0F);
}

inline float smooth(float edge0, float edge1, float x) {
  const float t = (x - edge0) / (edge1 - edge0);
  const float c = t < 0 ? 0.0F : (t > 1 ? 1.0F : t);
  return c * c * (3 - 2 * c);
}

/// Value noise, 0..1, features one unit wide.
inline float value_noise(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const float tx = x - fx, ty = y - fy;
  const float sx = tx * tx * (3 - 2 * tx), sy = ty * ty * (3 - 2 * ty);
  const float a = chance(ix, iy, seed), b = chance(ix + 1, iy, seed);
  const float c = chance(ix, iy + 1, seed), d = chance(ix + 1, iy + 1, seed);
  return (a + (b - a) * sx) * (1 - sy) + (c + (d - c) * sx) * sy;
}

/// Sum of octaves, each half as wide and half as strong; 0..1.
inline float layered_noise(float x, float y, std::uint32_t seed, int octaves) {
  float sum = 0, weight = 0, amplitude = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * value_noise(x, y, seed + static_cast<std::uint32_t>(i) * 101U);
    weight += amplitude;
    amplitude *= 0.5F;
    x = x * 2 + 17.3F;
    y = y * 2 + 5.7F;
  }
  return sum / weight;
}

}  // namespace foreview::synthetic
