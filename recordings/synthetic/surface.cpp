#include "foreview/recordings/synthetic/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "foreview/recordings/synthetic/lettering.h"
#include "foreview/recordings/synthetic/noise.h"

namespace foreview::synthetic {
namespace {

using glm::mix;
using glm::vec2;
using glm::vec3;

constexpr float kSoft = 0.002F;  // half the width over which an edge changes, metres

/// 1 inside lo..hi, 0 outside, soft edges.
float band(float x, float lo, float hi) {
  return smooth(lo - kSoft, lo + kSoft, x) * (1 - smooth(hi - kSoft, hi + kSoft, x));
}
float rectangle(vec2 p, vec2 lo, vec2 hi) {
  return band(p.x, lo.x, hi.x) * band(p.y, lo.y, hi.y);
}
float disc(vec2 p, vec2 centre, float radius) {
  return 1 - smooth(radius - kSoft, radius + kSoft, glm::length(p - centre));
}
float ring(vec2 p, vec2 centre, float radius, float width) {
  return band(glm::length(p - centre), radius - width / 2, radius + width / 2);
}
/// Square wave of a period, 1 in the first half, soft edges.
float stripes(float x, float period) {
  const float t = x - period * std::floor(x / period);
  return band(t, 0, period / 2) + (1 - smooth(0, kSoft, period - t)) * 0.5F;
}
float wrap(float x, float period) {
  return x - period * std::floor(x / period);
}
float text(std::string_view letters, vec2 p, vec2 lower_left, float dot) {
  return lettering_ink(letters, p.x - lower_left.x, p.y - lower_left.y, dot);
}
/// Bars of a code, each a multiple of 4 mm wide.
float bar_code(vec2 p, vec2 lo, vec2 hi, std::uint32_t seed) {
  if (p.x < lo.x || p.x > hi.x) return 0;
  const float cell = (p.x - lo.x) / 0.005F;
  const int i = static_cast<int>(cell);
  const auto bar = [&](int k) { return chance(k, 7, seed) > 0.5F ? 1.0F : 0.0F; };
  const float t = cell - static_cast<float>(i);
  const float ink = mix(bar(i), bar(i + 1), smooth(0.6F, 1.0F, t));
  return ink * band(p.y, lo.y, hi.y);
}
/// Lines of pretended small print: dark dashes 6 mm high.
float small_print(vec2 p, vec2 lo, vec2 hi, float pitch, std::uint32_t seed) {
  if (p.x < lo.x || p.x > hi.x || p.y < lo.y || p.y > hi.y) return 0;
  const int line = static_cast<int>((hi.y - p.y) / pitch);
  const float in_line = (hi.y - p.y) - static_cast<float>(line) * pitch;
  const float length = (hi.x - lo.x) * (0.55F + 0.45F * chance(line, 3, seed));
  if (p.x - lo.x > length) return 0;
  const float word = value_noise((p.x - lo.x) / 0.013F, static_cast<float>(line) * 7.1F, seed);
  return band(in_line, pitch * 0.2F, pitch * 0.75F) * smooth(0.3F, 0.45F, word);
}

vec3 paint(const Surface& s, vec2 p) {
  const float mottle = layered_noise(p.x * 3, p.y * 3, s.seed, 3);
  const float scuff = smooth(0.72F, 0.8F, value_noise(p.x * 14, p.y * 40, s.seed + 9));
  return s.colour * (0.88F + 0.24F * mottle) * (1 - 0.12F * scuff);
}

vec3 wood(const Surface& s, vec2 p) {
  const float board = std::floor(p.y / 0.12F);
  const float shift = chance(static_cast<int>(board), 1, s.seed) * 9;
  const float warp = layered_noise(p.x * 1.5F + shift, p.y * 8, s.seed, 3) * 0.10F;
  const float rings = 0.5F + 0.5F * std::sin((p.y + warp) * 170 + shift);
  const float fibre = value_noise(p.x * 8 + shift, p.y * 160, s.seed + 3);
  const float tone = 0.85F + 0.3F * chance(static_cast<int>(board), 2, s.seed);
  vec3 c = mix(s.colour, s.second_colour, 0.55F * rings * rings + 0.30F * fibre) * tone;
  const float knot_x = wrap(p.x + shift, 0.7F) - 0.35F, knot_y = wrap(p.y, 0.12F) - 0.06F;
  c *= 1 - 0.5F * (1 - smooth(0.008F, 0.022F, std::sqrt(knot_x * knot_x + knot_y * knot_y * 4)));
  return c * (1 - 0.55F * (1 - smooth(0.001F, 0.005F, std::min(wrap(p.y, 0.12F), 0.12F - wrap(p.y, 0.12F)))));
}

vec3 brick(const Surface& s, vec2 p) {
  constexpr float kLength = 0.25F, kHeight = 0.085F, kJoint = 0.014F;
  const float course = std::floor(p.y / kHeight);
  const float x = p.x + (std::fmod(std::abs(course), 2.0F) > 0.5F ? kLength / 2 : 0);
  const float column = std::floor(x / kLength);
  const vec2 in{x - column * kLength, p.y - course * kHeight};
  const float inside = band(in.x, kJoint / 2, kLength - kJoint / 2) * band(in.y, kJoint / 2, kHeight - kJoint / 2);
  const float tone = 0.55F + 0.7F * chance(static_cast<int>(column), static_cast<int>(course), s.seed);
  const float grain = layered_noise(p.x * 60, p.y * 60, s.seed + 5, 2);
  const vec3 face = s.colour * tone * (0.75F + 0.5F * grain);
  return mix(s.second_colour * (0.85F + 0.3F * grain), face, inside);
}

vec3 floor_tiles(const Surface& s, vec2 p) {
  constexpr float kTile = 0.25F;
  const int i = static_cast<int>(std::floor(p.x / kTile)), j = static_cast<int>(std::floor(p.y / kTile));
  const vec2 in{wrap(p.x, kTile), wrap(p.y, kTile)};
  const bool odd = ((i + j) & 1) != 0;
  const vec3 base = (odd ? s.colour : s.second_colour) * (0.85F + 0.3F * chance(i, j, s.seed));
  const float cloud = layered_noise(p.x * 12, p.y * 12, s.seed + 1, 2);
  const float light = smooth(0.70F, 0.78F, value_noise(p.x * 95, p.y * 95, s.seed + 2));
  const float dark = smooth(0.72F, 0.80F, value_noise(p.x * 70, p.y * 70, s.seed + 3));
  vec3 c = base * (0.8F + 0.4F * cloud);
  c = mix(c, vec3(0.85F, 0.82F, 0.76F), 0.5F * light);
  c = mix(c, vec3(0.08F), 0.45F * dark);
  const float joint = 1 - band(in.x, 0.004F, kTile - 0.004F) * band(in.y, 0.004F, kTile - 0.004F);
  return mix(c, vec3(0.33F, 0.31F, 0.29F), joint);
}

vec3 ceiling(const Surface& s, vec2 p) {
  const vec2 cell{wrap(p.x, 0.5F), wrap(p.y, 0.5F)};
  const float joint = 1 - rectangle(cell, vec2(0.008F), vec2(0.492F));
  const vec2 hole{wrap(p.x, 0.05F) - 0.025F, wrap(p.y, 0.05F) - 0.025F};
  vec3 c = s.colour * (0.93F + 0.1F * layered_noise(p.x * 9, p.y * 9, s.seed, 2));
  c *= 1 - 0.55F * disc(hole, vec2(0), 0.009F);
  return mix(c, s.second_colour, joint);
}

vec3 metal(const Surface& s, vec2 p, vec2 size) {
  const float brush =
      value_noise(p.x * 5, p.y * 190, s.seed) * 0.6F + value_noise(p.x * 2, p.y * 70, s.seed + 1) * 0.4F;
  vec3 c = s.colour * (0.76F + 0.48F * brush);
  const float smear = layered_noise(p.x * 7, p.y * 7, s.seed + 4, 2);
  c *= 0.85F + 0.3F * smear;
  if (size.x > 0.06F && size.y > 0.06F) {
    const vec2 q{std::min(p.x, size.x - p.x), std::min(p.y, size.y - p.y)};
    c = mix(c, s.second_colour, disc(q, vec2(0.02F), 0.008F));
  }
  if (!s.text.empty()) {
    const float dot =
        std::clamp(std::min(size.y / 16, size.x / (static_cast<float>(s.text.size()) * 7)), 0.0025F, 0.02F);
    const vec2 start{(size.x - lettering_width(s.text, dot)) / 2, size.y / 2 - 3.5F * dot};
    c = mix(c, s.second_colour, text(s.text, p, start, dot));
  }
  return c;
}

vec3 carton(const Surface& s, vec2 p, vec2 size) {
  const float flute = 0.5F + 0.5F * std::sin(p.x * 420);
  const float fibre = layered_noise(p.x * 25, p.y * 90, s.seed, 2);
  vec3 c = s.colour * (0.82F + 0.26F * fibre + 0.06F * flute);
  const float tape_half = std::min(0.025F, size.y * 0.15F);
  c = mix(c, vec3(0.80F, 0.66F, 0.42F), 0.7F * band(p.y, size.y / 2 - tape_half, size.y / 2 + tape_half));
  const float dot = std::clamp(size.x / 50, 0.003F, 0.009F);
  c = mix(c, s.second_colour, text(s.text, p, {size.x * 0.08F, size.y * 0.72F}, dot));
  const vec2 mark{size.x * 0.82F, size.y * 0.22F};
  const float r = std::min(size.x, size.y) * 0.12F;
  c = mix(
      c, s.second_colour,
      std::max(ring(p, mark, r, 0.008F), rectangle(p, mark - vec2(0.004F, r * 0.6F), mark + vec2(0.004F, r * 0.6F))));
  const vec2 label_lo{size.x * 0.08F, size.y * 0.10F}, label_hi{size.x * 0.55F, size.y * 0.38F};
  c = mix(c, vec3(0.93F), rectangle(p, label_lo, label_hi));
  return mix(c, vec3(0.08F), bar_code(p, label_lo + vec2(0.01F), {label_hi.x - 0.01F, label_hi.y - 0.012F}, s.seed));
}

vec3 label(const Surface& s, vec2 p, vec2 size) {
  vec3 c = s.colour * (0.92F + 0.16F * layered_noise(p.x * 20, p.y * 20, s.seed, 2));
  const float lo = size.y * 0.18F, hi = size.y * 0.82F;
  const float on = band(p.y, lo, hi);
  vec3 paper{0.94F, 0.93F, 0.88F};
  paper = mix(paper, s.second_colour, band(p.y, hi - size.y * 0.16F, hi));
  // The label repeats around the body: a name, then a bar code.
  const float half = std::max(size.x / 2, 0.05F);
  const vec2 q{wrap(p.x, half), p.y};
  const float dot = std::clamp(half / (static_cast<float>(s.text.size()) * 6.5F), 0.0022F, 0.012F);
  float ink = text(s.text, q, {half * 0.04F, lo + (hi - lo) * 0.38F}, dot);
  ink = std::max(ink, bar_code(q, {half * 0.1F, lo + 0.006F}, {half * 0.8F, lo + (hi - lo) * 0.28F}, s.seed));
  paper = mix(paper, vec3(0.10F, 0.10F, 0.14F), ink);
  return mix(c, paper, on);
}

vec3 hazard(const Surface& s, vec2 p) {
  const float on = stripes(p.x + p.y, 0.12F);
  const float wear = smooth(0.66F, 0.76F, layered_noise(p.x * 30, p.y * 30, s.seed, 2));
  return mix(mix(s.second_colour, s.colour, on), vec3(0.45F), 0.6F * wear);
}

vec3 poster(const Surface& s, vec2 p, vec2 size) {
  const vec2 q = p / size;
  vec3 c =
      mix(s.colour, s.second_colour, smooth(0.1F, 0.9F, q.y + 0.15F * std::sin(q.x * 5 + static_cast<float>(s.seed))));
  for (int i = 0; i < 7; ++i) {
    const vec2 centre{size.x * chance(i, 1, s.seed), size.y * (0.3F + 0.55F * chance(i, 2, s.seed))};
    const float r = std::min(size.x, size.y) * (0.06F + 0.16F * chance(i, 3, s.seed));
    const vec3 tint{chance(i, 4, s.seed), chance(i, 5, s.seed), chance(i, 6, s.seed)};
    const float shape = (i % 3 == 0) ? rectangle(p, centre - vec2(r, r * 0.6F), centre + vec2(r, r * 0.6F))
                                     : (i % 3 == 1 ? disc(p, centre, r) : ring(p, centre, r, r * 0.35F));
    c = mix(c, 0.1F + 0.85F * tint, 0.85F * shape);
  }
  const float strip = band(p.y, size.y * 0.06F, size.y * 0.26F);
  c = mix(c, vec3(0.95F, 0.94F, 0.90F), strip);
  c = mix(c, vec3(0.1F),
          0.85F * small_print(p, {size.x * 0.07F, size.y * 0.08F}, {size.x * 0.93F, size.y * 0.24F}, 0.018F, s.seed));
  const float dot = std::min(size.x * 0.86F / std::max(lettering_width(s.text, 1), 1.0F), size.y * 0.10F / 7);
  c = mix(c, vec3(0.98F), rectangle(p, {0, size.y * 0.86F}, {size.x, size.y}));
  c = mix(c, vec3(0.75F, 0.1F, 0.1F), text(s.text, p, {size.x * 0.07F, size.y * 0.93F - 3.5F * dot}, dot));
  const float frame = 1 - rectangle(p, vec2(0.012F), size - vec2(0.012F));
  return mix(c, vec3(0.12F), frame);
}

vec3 spine(const Surface& s, vec2 p, vec2 size) {
  vec3 c = s.colour * (0.9F + 0.2F * layered_noise(p.x * 40, p.y * 12, s.seed, 2));
  c = mix(c, vec3(0.93F, 0.92F, 0.86F),
          rectangle(p, {size.x * 0.14F, size.y * 0.42F}, {size.x * 0.86F, size.y * 0.9F}));
  const float dot = std::clamp(std::min(size.x * 0.5F / 7, size.y * 0.44F / std::max(lettering_width(s.text, 1), 1.0F)),
                               0.002F, 0.01F);
  // Lettering that reads upwards: turn the plane by a quarter.
  const vec2 turned{p.y, size.x - p.x};
  c = mix(c, s.second_colour, text(s.text, turned, {size.y * 0.45F, size.x / 2 - 3.5F * dot}, dot));
  c = mix(c, s.second_colour, disc(p, {size.x / 2, size.y * 0.2F}, std::min(0.02F, size.x * 0.3F)));
  return mix(c, s.second_colour,
             std::max(band(p.y, size.y * 0.06F, size.y * 0.09F), band(p.y, size.y * 0.34F, size.y * 0.37F)));
}

vec3 marker(const Surface& s, vec2 p, vec2 size) {
  const int n = 7;
  const vec2 q = p / size * static_cast<float>(n);
  const auto cell = [&](int i, int j) {
    if (i <= 0 || j <= 0 || i >= n - 1 || j >= n - 1) return (i < 0 || j < 0 || i >= n || j >= n) ? 1.0F : 0.0F;
    return chance(i, j, s.seed) > 0.5F ? 1.0F : 0.0F;
  };
  const vec2 f{q.x - 0.5F, q.y - 0.5F};
  const int i = static_cast<int>(std::floor(f.x)), j = static_cast<int>(std::floor(f.y));
  const float soft = kSoft / (std::min(size.x, size.y) / static_cast<float>(n));
  const float tx = smooth(0.5F - soft, 0.5F + soft, f.x - static_cast<float>(i));
  const float ty = smooth(0.5F - soft, 0.5F + soft, f.y - static_cast<float>(j));
  const float white = mix(mix(cell(i, j), cell(i + 1, j), tx), mix(cell(i, j + 1), cell(i + 1, j + 1), tx), ty);
  return mix(s.second_colour, s.colour, white);
}

vec3 breadboard(const Surface& s, vec2 p) {
  const vec2 hole{wrap(p.x, 0.05F) - 0.025F, wrap(p.y, 0.05F) - 0.025F};
  vec3 c = s.colour * (0.8F + 0.4F * layered_noise(p.x * 30, p.y * 9, s.seed, 3));
  c = mix(c, vec3(0.62F), 0.5F * ring(hole, vec2(0), 0.011F, 0.004F));
  c = mix(c, vec3(0.02F), disc(hole, vec2(0), 0.008F));
  const float scratch = smooth(0.80F, 0.86F, value_noise(p.x * 9 + p.y * 30, p.y * 60, s.seed + 8));
  return mix(c, s.second_colour, 0.5F * scratch);
}

vec3 screen(const Surface& s, vec2 p, vec2 size) {
  const float frame = 1 - rectangle(p, vec2(0.015F), size - vec2(0.015F));
  vec3 c = mix(s.colour, s.second_colour, p.y / size.y);
  const vec2 grid{wrap(p.x, 0.06F), wrap(p.y, 0.06F)};
  c = mix(c, vec3(0.25F, 0.35F, 0.45F), 0.6F * std::max(band(grid.x, 0, 0.004F), band(grid.y, 0, 0.004F)));
  for (int i = 0; i < 3; ++i) {
    const float y = size.y * (0.3F + 0.18F * static_cast<float>(i)) +
                    size.y * 0.16F * (layered_noise(p.x * 22, static_cast<float>(i) * 9, s.seed, 2) - 0.5F);
    const vec3 tint = i == 0 ? vec3(0.95F, 0.75F, 0.2F) : (i == 1 ? vec3(0.3F, 0.9F, 0.5F) : vec3(0.95F, 0.35F, 0.35F));
    c = mix(c, tint, band(p.y, y - 0.004F, y + 0.004F));
  }
  const float dot = std::clamp(size.x / 110, 0.0025F, 0.008F);
  c = mix(c, vec3(0.9F), text(s.text, p, {0.03F, size.y - 0.03F - 8 * dot}, dot));
  return mix(c, vec3(0.06F), frame);
}

vec3 cloth(const Surface& s, vec2 p) {
  const float a = stripes(p.x, 0.09F), b = stripes(p.y, 0.09F);
  const float weave = value_noise(p.x * 120, p.y * 120, s.seed);
  return mix(s.second_colour, s.colour, 0.5F * (a + b)) * (0.8F + 0.4F * weave);
}

}  // namespace

glm::vec3 surface_colour(const Surface& s, const glm::vec2& uv, const glm::vec2& size) {
  vec3 c{0};
  switch (s.material) {
    case Material::paint:
      c = paint(s, uv);
      break;
    case Material::wood:
      c = wood(s, uv);
      break;
    case Material::brick:
      c = brick(s, uv);
      break;
    case Material::floor:
      c = floor_tiles(s, uv);
      break;
    case Material::ceiling:
      c = ceiling(s, uv);
      break;
    case Material::metal:
      c = metal(s, uv, size);
      break;
    case Material::carton:
      c = carton(s, uv, size);
      break;
    case Material::label:
      c = label(s, uv, size);
      break;
    case Material::hazard:
      c = hazard(s, uv);
      break;
    case Material::poster:
      c = poster(s, uv, size);
      break;
    case Material::spine:
      c = spine(s, uv, size);
      break;
    case Material::marker:
      c = marker(s, uv, size);
      break;
    case Material::breadboard:
      c = breadboard(s, uv);
      break;
    case Material::screen:
      c = screen(s, uv, size);
      break;
    case Material::cloth:
      c = cloth(s, uv);
      break;
    case Material::lamp:
      c = s.colour;
      break;
  }
  return glm::clamp(c, 0.0F, 1.0F);
}

}  // namespace foreview::synthetic
