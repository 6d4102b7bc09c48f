#include "foreview/recordings/synthetic/workcell_things.h"

#include <array>
#include <cassert>
#include <cmath>
#include <string>

#include "foreview/recordings/synthetic/noise.h"

namespace foreview::synthetic {
namespace {

using glm::dvec3;
using glm::vec3;

constexpr std::array<const char*, 14> kNames{"M6 BOLTS", "SENSORS", "CABLE 5M", "SPARES", "FILTER",
                                             "VALVES",   "BEARING", "RELAYS",   "GASKET", "MOTOR 24V",
                                             "TOOLS",    "PUMP-3",  "SEALS",    "FUSES"};

/// Foot in the middle of the underside.
Pose standing(const dvec3& foot, const dvec3& size, double yaw) {
  return placed(foot + dvec3(0, 0, size.z / 2), yaw);
}

}  // namespace

WorkcellThings::WorkcellThings(SiteBuilder& builder, std::uint32_t part) : builder_(builder), part_(part) {}

float WorkcellThings::dice() {
  return chance(++rolled_, 11, 2005);
}

vec3 WorkcellThings::bright_colour() {
  static const std::array<vec3, 8> kColours{{{0.75F, 0.18F, 0.15F},
                                             {0.15F, 0.38F, 0.65F},
                                             {0.18F, 0.50F, 0.28F},
                                             {0.88F, 0.70F, 0.15F},
                                             {0.82F, 0.82F, 0.80F},
                                             {0.20F, 0.21F, 0.24F},
                                             {0.85F, 0.42F, 0.12F},
                                             {0.35F, 0.62F, 0.66F}}};
  return kColours[static_cast<std::size_t>(dice() * 7.999F)];
}

void WorkcellThings::carton(const dvec3& foot, const dvec3& size, double yaw) {
  builder_.begin_object();
  const vec3 board = vec3(0.66F, 0.49F, 0.31F) * (0.8F + 0.4F * dice());
  const auto name = kNames[static_cast<std::size_t>(dice() * 13.99F)];
  builder_.box(
      part_, standing(foot, size, yaw), size,
      builder_.surface({Material::carton, board, dice() > 0.5F ? vec3(0.12F) : vec3(0.65F, 0.1F, 0.1F), 0, name}));
  builder_.end_object();
}

void WorkcellThings::bin(const dvec3& foot, const dvec3& size, double yaw) {
  builder_.begin_object();
  const auto name = kNames[static_cast<std::size_t>(dice() * 13.99F)];
  const vec3 colour = bright_colour();
  builder_.box(part_, standing(foot, size, yaw), size,
               {builder_.surface({Material::label, colour, bright_colour(), 0, name}),
                builder_.surface({Material::paint, colour, vec3(0), 0, ""})});
  builder_.end_object();
}

void WorkcellThings::binder(const dvec3& foot, const dvec3& size) {
  builder_.begin_object();
  const auto name = kNames[static_cast<std::size_t>(dice() * 13.99F)];
  const vec3 colour = bright_colour();
  builder_.box(part_, standing(foot, size, 0), size,
               {builder_.surface({Material::spine, colour, vec3(0.13F, 0.13F, 0.2F), 0, name}),
                builder_.surface({Material::paint, colour * 0.8F, vec3(0), 0, ""})});
  builder_.end_object();
}

void WorkcellThings::bottle(const dvec3& foot, double radius, double height, int sides) {
  builder_.begin_object();
  const auto name = kNames[static_cast<std::size_t>(dice() * 13.99F)];
  const std::uint32_t body = builder_.surface({Material::label, bright_colour(), bright_colour(), 0, name});
  const std::uint32_t cap = builder_.surface({Material::paint, bright_colour(), vec3(0), 0, ""});
  builder_.lathe(part_, placed(foot, dice() * 6),
                 {{radius, 0, body},
                  {radius, height * 0.72, body},
                  {radius * 0.45, height * 0.86, cap},
                  {radius * 0.45, height, cap}},
                 sides, cap, cap);
  builder_.end_object();
}

void WorkcellThings::can(const dvec3& foot, double radius, double height, int sides) {
  builder_.begin_object();
  const auto name = kNames[static_cast<std::size_t>(dice() * 13.99F)];
  const std::uint32_t body = builder_.surface({Material::label, bright_colour(), bright_colour(), 0, name});
  const std::uint32_t lid = builder_.surface({Material::metal, vec3(0.6F), vec3(0.3F), 0, ""});
  builder_.prism(part_, placed(foot, dice() * 6), radius, 0, height, sides, body, lid);
  builder_.end_object();
}

void WorkcellThings::row(const dvec3& start, double length, double depth, double headroom) {
  double x = 0.03;
  while (x < length - 0.08) {
    const float kind = dice();
    const double gap = 0.05 + 0.22 * dice();
    const double tall = headroom * (0.55 + 0.35 * dice());
    if (kind < 0.48F) {
      const double w = std::min(0.24 + 0.22 * dice(), length - x);
      carton(start + dvec3(x + w / 2, depth * 0.5, 0), {w, depth * 0.8, tall}, 0.12 * (dice() - 0.5));
      x += w + gap;
    } else if (kind < 0.59F) {
      const int count = 2 + static_cast<int>(dice() * 1.5);
      for (int i = 0; i < count && x < length - 0.06; ++i) {
        const double w = 0.05 + 0.025 * dice();
        binder(start + dvec3(x + w / 2, depth * 0.45, 0), {w, depth * 0.75, headroom * 0.86});
        x += w + 0.004;
      }
      x += gap;
    } else if (kind < 0.92F) {
      const double w = std::min(0.24 + 0.18 * dice(), length - x);
      bin(start + dvec3(x + w / 2, depth * 0.5, 0), {w, depth * 0.85, tall * 0.7}, 0);
      x += w + gap;
    } else if (kind < 0.96F) {
      const double r = 0.035 + 0.02 * dice();
      bottle(start + dvec3(x + r, depth * (0.35 + 0.2 * dice()), 0), r, std::min(tall, 0.30), 8);
      x += 2 * r + gap;
    } else {
      const double r = 0.045 + 0.03 * dice();
      can(start + dvec3(x + r, depth * (0.35 + 0.2 * dice()), 0), r, tall * 0.6, 10);
      x += 2 * r + gap;
    }
  }
}

void WorkcellThings::build_shell(const dvec3& room) {
  SiteBuilder::BoxSurfaces walls(0);
  walls.left = builder_.surface({Material::brick, {0.66F, 0.33F, 0.24F}, {0.80F, 0.77F, 0.72F}, 0, ""});
  walls.front = builder_.surface({Material::brick, {0.70F, 0.68F, 0.63F}, {0.42F, 0.41F, 0.40F}, 0, ""});
  walls.back = builder_.surface({Material::brick, {0.80F, 0.79F, 0.74F}, {0.50F, 0.49F, 0.47F}, 0, ""});
  walls.right = builder_.surface({Material::wood, {0.74F, 0.55F, 0.35F}, {0.42F, 0.27F, 0.15F}, 0, ""});
  walls.bottom = builder_.surface({Material::floor, {0.62F, 0.58F, 0.52F}, {0.30F, 0.34F, 0.37F}, 0, ""});
  walls.top = builder_.surface({Material::ceiling, {0.86F, 0.86F, 0.84F}, {0.45F, 0.46F, 0.48F}, 0, ""});
  builder_.box(part_, {{1, 0, 0, 0}, room * 0.5}, room, walls, {10, 9, 5}, true);

  const std::uint32_t housing = builder_.surface({Material::paint, {0.75F, 0.75F, 0.75F}, vec3(0), 0, ""});
  const std::uint32_t lamp = builder_.surface({Material::lamp, {1.0F, 0.98F, 0.92F}, vec3(0), 0, ""});
  const std::uint32_t sky = builder_.surface({Material::lamp, {0.82F, 0.91F, 1.0F}, vec3(0), 0, ""});
  SiteBuilder::BoxSurfaces ceiling_lamp(housing), window(housing);
  ceiling_lamp.bottom = lamp;
  window.back = sky;
  builder_.box(part_, placed({1.5, 2.3, 2.43}), {1.2, 0.3, 0.10}, ceiling_lamp, {3, 1, 1});
  builder_.box(part_, placed({3.5, 2.0, 2.43}), {1.2, 0.3, 0.10}, ceiling_lamp, {3, 1, 1});
  builder_.box(part_, placed({4.0, 0.02, 1.6}), {1.0, 0.03, 0.9}, window, {2, 1, 2});
  const auto poster = [&](const dvec3& centre, const dvec3& size, const char* title, vec3 a, vec3 b) {
    const std::uint32_t print = builder_.surface({Material::poster, a, b, 0, title});
    builder_.box(part_, placed(centre), size, {print, housing}, {size.x > 0.1 ? 2 : 1, size.y > 0.1 ? 2 : 1, 2});
  };
  poster({0.012, 0.62, 1.62}, {0.02, 0.75, 0.95}, "SAFETY FIRST", {0.15F, 0.35F, 0.60F}, {0.85F, 0.85F, 0.60F});
  poster({0.012, 3.05, 1.55}, {0.02, 0.60, 0.80}, "TORQUE CHART", {0.80F, 0.75F, 0.60F}, {0.55F, 0.20F, 0.15F});
  poster({4.988, 3.3, 1.70}, {0.02, 0.80, 0.80}, "CELL 7 LAYOUT", {0.20F, 0.45F, 0.35F}, {0.90F, 0.90F, 0.85F});
}

void WorkcellThings::build_bench(const glm::dvec2& centre, const glm::dvec2& size, double height) {
  const std::uint32_t top = builder_.surface({Material::wood, {0.80F, 0.62F, 0.40F}, {0.50F, 0.32F, 0.17F}, 0, ""});
  const std::uint32_t edge = builder_.surface({Material::hazard, {0.93F, 0.76F, 0.12F}, {0.10F, 0.10F, 0.10F}, 0, ""});
  const std::uint32_t steel = builder_.surface({Material::metal, {0.50F, 0.53F, 0.56F}, {0.2F, 0.2F, 0.2F}, 0, ""});
  builder_.box(part_, placed({centre, height - 0.03}), {size, 0.06}, {edge, top}, {6, 3, 1});
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      builder_.box(
          part_,
          placed({centre.x + sx * (size.x / 2 - 0.06), centre.y + sy * (size.y / 2 - 0.06), (height - 0.06) / 2}),
          {0.07, 0.07, height - 0.06}, steel, {1, 1, 1});
    }
  }
  builder_.box(part_, placed({centre.x, centre.y, 0.22}), {size.x - 0.2, size.y - 0.2, 0.03}, steel, {4, 2, 1});
  for (int i = 0; i < 3; ++i)
    carton({centre.x - 0.7 + i * 0.65, centre.y - 0.05, 0.235}, {0.42, 0.5, 0.30 + 0.04 * i}, 0.1 * i);

  // What lies on the bench, around the arm's places.
  const std::uint32_t plate =
      builder_.surface({Material::breadboard, {0.17F, 0.18F, 0.21F}, {0.55F, 0.56F, 0.6F}, 0, ""});
  builder_.begin_object();
  builder_.box(part_, placed({2.45, 2.78, height + 0.008}), {0.40, 0.40, 0.016}, {steel, plate});
  builder_.end_object();
  const std::uint32_t mat = builder_.surface({Material::cloth, {0.78F, 0.80F, 0.78F}, {0.22F, 0.38F, 0.50F}, 0, ""});
  builder_.begin_object();
  builder_.box(part_, placed({3.42, 2.80, height + 0.004}, 0.2), {0.36, 0.36, 0.008}, {mat, mat});
  builder_.end_object();
  const std::uint32_t board = builder_.surface({Material::marker, {0.95F, 0.94F, 0.9F}, {0.07F, 0.07F, 0.08F}, 0, ""});
  builder_.begin_object();
  builder_.box(part_, placed({1.52, 2.72, height + 0.006}, -0.25), {0.28, 0.28, 0.012}, {steel, board});
  builder_.end_object();
  bin({3.45, 2.80, height + 0.008}, {0.20, 0.16, 0.12}, 0.5);
  bin({1.55, 3.10, height}, {0.26, 0.18, 0.14}, -0.2);
  carton({3.35, 3.20, height}, {0.30, 0.24, 0.22}, 0.3);
  carton({1.95, 3.25, height}, {0.22, 0.20, 0.17}, -0.4);
  bottle({1.86, 2.64, height}, 0.04, 0.20, 7);
  bottle({2.80, 3.05, height}, 0.045, 0.24, 7);
  bottle({3.20, 2.97, height}, 0.036, 0.18, 6);
  can({1.74, 2.92, height}, 0.055, 0.12, 8);
  can({2.72, 2.60, height}, 0.040, 0.09, 8);
  can({3.24, 2.58, height}, 0.05, 0.11, 8);
  const std::uint32_t hex = builder_.surface({Material::metal, {0.68F, 0.62F, 0.45F}, {0.3F, 0.3F, 0.3F}, 0, "M24"});
  for (int i = 0; i < 2; ++i) {
    builder_.begin_object();
    builder_.prism(part_, placed({2.34 + 0.09 * i, 2.70 + 0.05 * (i % 2), height + 0.016}, i), 0.032, 0, 0.035, 6, hex,
                   hex);
    builder_.end_object();
  }
  // A monitor on its foot.
  const std::uint32_t black = builder_.surface({Material::paint, {0.13F, 0.13F, 0.14F}, vec3(0), 0, ""});
  SiteBuilder::BoxSurfaces monitor(black);
  monitor.front =
      builder_.surface({Material::screen, {0.06F, 0.09F, 0.16F}, {0.10F, 0.18F, 0.30F}, 0, "ARM READY 24.8"});
  builder_.begin_object();
  builder_.box(part_, placed({3.05, 3.36, height + 0.30}, 0.15), {0.52, 0.04, 0.34}, monitor, {2, 1, 1});
  builder_.box(part_, placed({3.05, 3.38, height + 0.065}, 0.15), {0.06, 0.03, 0.13}, black);
  builder_.end_object();
}

void WorkcellThings::build_shelf(const glm::dvec2& corner, double length) {
  const std::uint32_t board = builder_.surface({Material::wood, {0.62F, 0.45F, 0.28F}, {0.36F, 0.23F, 0.13F}, 0, ""});
  const std::uint32_t upright = builder_.surface({Material::metal, {0.32F, 0.36F, 0.42F}, {0.1F, 0.1F, 0.1F}, 0, ""});
  constexpr double kDepth = 0.30;
  constexpr int kBays = 2;
  const std::array<double, 4> heights{0.28, 0.78, 1.27, 1.75};
  for (const double z : heights) {
    builder_.box(part_, placed({corner.x + length / 2, corner.y + kDepth / 2, z}), {length, kDepth, 0.03}, board,
                 {7, 1, 1});
  }
  const double bay = (length + 0.04) / kBays;
  for (int i = 0; i <= kBays; ++i) {
    builder_.box(part_, placed({corner.x - 0.02 + i * bay, corner.y + kDepth / 2, 1.04}), {0.03, kDepth + 0.01, 2.08},
                 upright, {1, 1, 3});
  }
  for (std::size_t level = 0; level < heights.size(); ++level) {
    const double headroom = level + 1 < heights.size() ? heights[level + 1] - heights[level] - 0.05 : 0.40;
    for (int b = 0; b < kBays; ++b) {
      row({corner.x + b * bay, corner.y, heights[level] + 0.015}, bay - 0.05, kDepth, headroom);
    }
  }
}

void WorkcellThings::build_side_rack() {
  const std::uint32_t steel =
      builder_.surface({Material::metal, {0.55F, 0.30F, 0.25F}, {0.2F, 0.2F, 0.2F}, 0, "RACK 2"});
  // Low, along the left wall.
  for (const double z : {0.45, 0.90}) {
    builder_.box(part_, placed({0.22, 3.0, z}), {0.36, 1.5, 0.03}, steel, {1, 3, 1});
  }
  for (const double y : {2.27, 3.73}) {
    builder_.box(part_, placed({0.22, y, 0.46}), {0.36, 0.03, 0.92}, steel, {1, 1, 2});
  }
  for (int i = 0; i < 4; ++i) {
    bin({0.22, 2.45 + 0.33 * i, 0.465}, {0.26, 0.24, 0.20}, 0.05 * i);
    can({0.20, 2.45 + 0.33 * i, 0.915}, 0.06 + 0.01 * i, 0.16, 6 + 2 * (i % 2));
  }
  carton({0.25, 2.75, 0.0}, {0.30, 0.5, 0.32}, 0.05);
  carton({0.25, 3.4, 0.0}, {0.30, 0.45, 0.28}, -0.05);
}

void WorkcellThings::build_machine() {
  // A control cabinet in the right corner.
  const std::uint32_t shell = builder_.surface({Material::metal, {0.70F, 0.72F, 0.70F}, {0.15F, 0.2F, 0.35F}, 0, ""});
  const std::uint32_t side =
      builder_.surface({Material::poster, {0.60F, 0.66F, 0.66F}, {0.40F, 0.46F, 0.52F}, 0, "CONTROL"});
  SiteBuilder::BoxSurfaces cabinet(side, shell);
  builder_.box(part_, placed({4.55, 2.6, 0.80}), {0.6, 0.9, 1.6}, cabinet, {2, 2, 4});
  const std::uint32_t stripe =
      builder_.surface({Material::hazard, {0.93F, 0.76F, 0.12F}, {0.10F, 0.10F, 0.10F}, 0, ""});
  builder_.box(part_, placed({4.55, 2.6, 1.63}), {0.5, 0.8, 0.06}, stripe, {1, 2, 1});
  for (int i = 0; i < 3; ++i) can({4.42 + 0.1 * (i % 2), 2.32 + 0.27 * i, 1.66}, 0.07, 0.22, 8);
  carton({4.5, 1.6, 0.0}, {0.5, 0.45, 0.42}, 0.2);
  carton({4.52, 1.6, 0.42}, {0.38, 0.35, 0.30}, -0.15);
  carton({0.9, 2.1, 0.0}, {0.4, 0.4, 0.35}, 0.5);
}

void WorkcellThings::fill_up_to(std::size_t faces) {
  // Drums and canisters on the floor by the front wall, stacked where it takes many.
  const auto left = [&] { return static_cast<int>(faces) - static_cast<int>(builder_.face_count()); };
  int i = 0;
  const auto store = [&](int sides) {
    can({0.35 + 0.24 * (i % 14), 0.22 + 0.01 * (i / 14 % 3), 0.34 * (i / 14)}, 0.10, 0.33, sides);
    ++i;
  };
  while (left() >= 20 + 14) store(12);
  assert(left() >= 12);
  store(left() - 2);
}

}  // namespace foreview::synthetic
