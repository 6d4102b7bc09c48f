#include "oracle/batched_gather.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview::oracle {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

constexpr double kNotThere = std::numeric_limits<double>::infinity();

/// From p, beside the edge, to it.
double distance_beside(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  const double length2 = glm::dot(b - a, b - a);
  if (length2 == 0) return kNotThere;
  const double t = glm::dot(p - a, b - a) / length2;
  return t < 0 || t > 1 ? kNotThere : glm::distance(a + (b - a) * t, p);
}

/// From p, beyond the corner b of two edges and beside neither of them, to it.
double distance_beyond(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& p) {
  if (glm::dot(p - b, b - a) < 0 || glm::dot(p - b, c - b) > 0) return kNotThere;
  return glm::distance(b, p);
}

bool contains(const std::vector<glm::dvec2>& outline, const glm::dvec2& p) {
  double area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    area += cross(outline[i] - outline[0], outline[(i + 1) % outline.size()] - outline[0]);
  }
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2& a = outline[i];
    const glm::dvec2& b = outline[(i + 1) % outline.size()];
    if (cross(b - a, p - a) * area < 0) return false;
  }
  return area != 0;
}

}  // namespace

Image<TexelOwner> texel_owners(const PolygonModel& model, const ChartLayout& layout, std::size_t group,
                               const std::vector<bool>& front) {
  const ChartGroup& block = layout.groups[group];
  Image<TexelOwner> result(block.size.x, block.size.y);
  AlphaImage nearest(block.size.x, block.size.y, std::numeric_limits<double>::infinity());  // edge with a gutter
  const auto members = layout.members_of(block);
  for (std::size_t member = 0; member < members.size(); ++member) {
    const std::uint32_t polygon = members[member];
    const Chart& chart = layout.charts[polygon];
    const Polygon& p = model.polygons()[polygon];
    std::vector<glm::dvec2> outline;
    glm::dvec2 least(std::numeric_limits<double>::infinity()), greatest = -least;
    for (std::size_t i = 0; i < p.corner_count; ++i) {
      const glm::dvec2 corner = chart.texel_from_part(model.corner(polygon, i)) - glm::dvec2(block.origin);
      least = {std::min(least.x, corner.x), std::min(least.y, corner.y)};
      greatest = {std::max(greatest.x, corner.x), std::max(greatest.y, corner.y)};
      outline.push_back(corner);
    }
    const int left = std::max(static_cast<int>(std::floor(least.x)) - kChartGutter, 0);
    const int top = std::max(static_cast<int>(std::floor(least.y)) - kChartGutter, 0);
    const int right = std::min(static_cast<int>(std::ceil(greatest.x)) + kChartGutter, block.size.x);
    const int bottom = std::min(static_cast<int>(std::ceil(greatest.y)) + kChartGutter, block.size.y);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        TexelOwner& owner = result.at(x, y);
        if (owner.inside) continue;
        const glm::dvec2 centre{x + 0.5, y + 0.5};
        if (contains(outline, centre)) {
          owner = {static_cast<int>(polygon), true};
          continue;
        }
        if (!front[member]) continue;
        const std::size_t count = outline.size();
        for (std::size_t i = 0; i < count; ++i) {
          const std::size_t next = (i + 1) % count;
          if (!layout.outline[p.first_corner + i]) continue;
          double distance = distance_beside(outline[i], outline[next], centre);
          if (layout.outline[p.first_corner + next]) {
            distance = std::min(distance, distance_beyond(outline[i], outline[next], outline[(i + 2) % count], centre));
          }
          if (distance > kChartGutter || distance >= nearest.at(x, y)) continue;
          nearest.at(x, y) = distance;
          owner = {static_cast<int>(polygon), false};
        }
      }
    }
  }
  return result;
}

namespace {

/// Whether the four pixels about (u, v) are in the picture, and the cell between their centres.
bool cell_of(const glm::dvec2& pixel, const CameraModel& camera, int& x, int& y) {
  const double left = std::floor(pixel.x - 0.5), top = std::floor(pixel.y - 0.5);
  if (!(left >= 0 && top >= 0 && left + 1 < camera.width && top + 1 < camera.height)) return false;
  x = static_cast<int>(left);
  y = static_cast<int>(top);
  return true;
}

glm::dvec3 bilinear(const ColourImage& colour, const glm::dvec2& pixel, int x, int y) {
  const double fx = pixel.x - 0.5 - x, fy = pixel.y - 0.5 - y;
  return colour.at(x, y) * (1 - fx) * (1 - fy) + colour.at(x + 1, y) * fx * (1 - fy) +
         colour.at(x, y + 1) * (1 - fx) * fy + colour.at(x + 1, y + 1) * fx * fy;
}

int samples_along(double pixels) {
  return static_cast<int>(std::clamp(std::ceil(pixels - 1e-3), 1.0, 4.0));
}

}  // namespace

GatheredTexel gather(const Chart& chart, const PictureSurface& surface, const glm::dvec2& texel,
                     const GatherSource& source) {
  GatheredTexel result;
  const CameraModel& camera = source.camera;
  const auto point = [&](const glm::dvec2& t) { return surface.camera_from_part * chart.part_from_texel(t); };
  const auto pixel_of = [&](const glm::dvec3& p) {
    return camera.principal_point + camera.focal_length * glm::dvec2(p.x / p.z, p.y / p.z);
  };
  const glm::dvec3 centre = point(texel);
  if (!(centre.z > source.near_plane)) return result;
  result.pixel = pixel_of(centre);
  result.w = 1 / centre.z;
  result.reach = std::abs(surface.a) + std::abs(surface.b);

  // A point of the plane moves linearly with its texel; d(x / z) = (dx - x / z dz) / z.
  const auto step_in_pixels = [&](const glm::dvec3& step) {
    const glm::dvec2 moved =
        (glm::dvec2(step) - glm::dvec2(centre) / centre.z * step.z) / centre.z * camera.focal_length;
    return glm::length(moved);
  };
  const double along_x = step_in_pixels(point(texel + glm::dvec2(1, 0)) - centre);
  const double along_y = step_in_pixels(point(texel + glm::dvec2(0, 1)) - centre);
  result.step = std::max(along_x, along_y);

  const double largest = std::max(camera.focal_length.x, camera.focal_length.y) * surface.range.greatest /
                         std::min(chart.texels_per_metre.x, chart.texels_per_metre.y);
  const int n = largest > kBatchedFootprint ? samples_along(along_x) : 1;
  const int m = largest > kBatchedFootprint ? samples_along(along_y) : 1;
  const double slack = std::min(result.reach, surface.range.size());
  bool all_in = true, all_fit = true;
  glm::dvec3 sum(0);
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      const glm::dvec3 p = point(texel + glm::dvec2((i + 0.5) / n - 0.5, (j + 0.5) / m - 0.5));
      int x = 0, y = 0;
      if (!(p.z > source.near_plane) || !cell_of(pixel_of(p), camera, x, y)) {
        all_in = false;
        continue;
      }
      const Cell& cell = source.cells->at(x, y);
      const double w = 1 / p.z;
      all_fit = all_fit && !cell.takes_nothing(surface.thin) && w + slack >= cell.least && w - slack <= cell.greatest;
      sum += bilinear(*source.colour, pixel_of(p), x, y);
    }
  }
  result.in_picture = all_in;
  result.taken = all_in && all_fit;
  if (result.taken) result.colour = sum / static_cast<double>(n * m);
  return result;
}

}  // namespace foreview::oracle
