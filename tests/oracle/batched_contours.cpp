#include "oracle/batched_contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "oracle/projection.h"

namespace foreview::oracle {
namespace {

constexpr double kEdgeDoubt = 1.0 / 64;  // pixels that a rasteriser may move an edge by, and more

bool is_thin(const PolygonModel& model, std::size_t polygon, const CameraModel& camera, const Pose& camera_from_part,
             double near_plane) {
  std::vector<glm::dvec2> pixels;
  for (std::size_t i = 0; i < model.polygons()[polygon].corner_count; ++i) {
    const glm::dvec3 corner = camera_from_part * model.corner(polygon, i);
    if (corner.z <= near_plane) return false;
    pixels.push_back(camera.focal_length * glm::dvec2(corner) / corner.z);
  }
  double area = 0, perimeter = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const glm::dvec2 &p = pixels[i], &q = pixels[(i + 1) % pixels.size()];
    area += (p.x * q.y - q.x * p.y) / 2;
    perimeter += glm::distance(p, q);
  }
  return 4 * std::abs(area) < perimeter && perimeter <= kBatchedThinPerimeter;
}

}  // namespace

double InverseRange::keep(double w) const {
  return std::min(std::max(w, least), greatest);
}

PictureSurface picture_surface(const PolygonModel& model, std::size_t polygon, const CameraModel& camera,
                               const CaptureState& state, double near_plane) {
  const Polygon& p = model.polygons()[polygon];
  const Pose camera_from_part = state.world_from_camera.inverse() * state.world_from_part[p.part];
  const glm::dvec3 normal = camera_from_part.rotate(p.normal);
  const double offset = p.offset + glm::dot(normal, camera_from_part.translation);
  PictureSurface result;
  result.camera_from_part = camera_from_part;
  result.front = offset < 0;
  result.shown = result.front && !project(model, polygon, camera, state, near_plane).box.empty();
  // dot(normal, z ray) == offset, and a ray is ((u - c_u) / f_u, (v - c_v) / f_v, 1).
  result.a = normal.x / camera.focal_length.x / offset;
  result.b = normal.y / camera.focal_length.y / offset;
  result.origin = normal.z / offset - result.a * camera.principal_point.x - result.b * camera.principal_point.y;
  double deviation = 1e-6;  // metres, what single precision may move a corner by
  for (std::size_t i = 0; i < p.corner_count; ++i) {
    deviation = std::max(deviation, std::abs(glm::dot(p.normal, model.corner(polygon, i)) - p.offset));
    const double w = 1 / std::max((camera_from_part * model.corner(polygon, i)).z, near_plane);
    result.range.least = i == 0 ? w : std::min(result.range.least, w);
    result.range.greatest = std::max(result.range.greatest, w);
  }
  result.thin = is_thin(model, polygon, camera, camera_from_part, near_plane);
  result.doubt = deviation / std::abs(offset);
  return result;
}

Image<Surface> surfaces(const PolygonModel& model, const CameraModel& camera, const CaptureState& state,
                        double near_plane) {
  struct Candidate {
    int polygon = -1;
    double distance = 0;  // pixels from the polygon's outline, positive inside
  };
  Image<std::vector<Candidate>> candidates(camera.width, camera.height);
  std::vector<PictureSurface> polygons;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    polygons.push_back(picture_surface(model, i, camera, state, near_plane));
    const ProjectedPolygon projected = project(model, i, camera, state, near_plane);
    for (int y = projected.grown_box.top; y < projected.grown_box.bottom; ++y) {
      for (int x = projected.grown_box.left; x < projected.grown_box.right; ++x) {
        const double distance = projected.signed_distance({x + 0.5, y + 0.5});
        if (distance >= -kEdgeDoubt) candidates.at(x, y).push_back({static_cast<int>(i), distance});
      }
    }
  }
  Image<Surface> result(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto polygon_of = [&](const Candidate& c) -> const PictureSurface& {
        return polygons[static_cast<std::size_t>(c.polygon)];
      };
      const auto w_of = [&](const Candidate& c) {
        return polygon_of(c).range.keep(polygon_of(c).plane_at(x + 0.5, y + 0.5));
      };
      Candidate nearest;
      for (const Candidate& c : candidates.at(x, y)) {
        if (c.distance >= 0 && (nearest.polygon < 0 || w_of(c) > w_of(nearest))) nearest = c;
      }
      Surface& surface = result.at(x, y);
      // Moved edges move depths with them.
      const auto doubt_of = [&](const Candidate& c) {
        return kEdgeDoubt * (std::abs(polygon_of(c).a) + std::abs(polygon_of(c).b)) +
               (1e-5 + polygon_of(c).doubt) * w_of(c);
      };
      for (const Candidate& c : candidates.at(x, y)) {
        const bool is_rival = c.polygon != nearest.polygon;
        if (is_rival && (nearest.polygon < 0 || w_of(c) + doubt_of(c) >= w_of(nearest) - doubt_of(nearest))) {
          surface.doubtful = true;
        }
      }
      if (nearest.polygon < 0) continue;
      if (nearest.distance <= kEdgeDoubt) surface.doubtful = true;
      surface.polygon = nearest.polygon;
      surface.a = polygon_of(nearest).a;
      surface.b = polygon_of(nearest).b;
      surface.range = polygon_of(nearest).range;
      surface.w = w_of(nearest);
    }
  }
  return result;
}

bool is_open(const Surface& p, const Surface& q, int dx, int dy) {
  const double at_p = p.w - q.continued(-dx, -dy);
  const double at_q = p.continued(dx, dy) - q.w;
  if (at_p * at_q <= 0) return false;
  return std::min(std::abs(at_p), std::abs(at_q)) > kBatchedGap * std::max(p.w, q.w);
}

namespace {

constexpr std::array<std::array<int, 2>, 4> kEdgeNeighbours{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

}  // namespace

AlphaImage rims(const Image<Surface>& surfaces) {
  AlphaImage result(surfaces.width, surfaces.height, 0.0);
  for (int y = 0; y < surfaces.height; ++y) {
    for (int x = 0; x < surfaces.width; ++x) {
      const Surface& p = surfaces.at(x, y);
      for (const auto& [dx, dy] : kEdgeNeighbours) {
        if (!surfaces.contains(x + dx, y + dy)) continue;
        const Surface& q = surfaces.at(x + dx, y + dy);
        if (p.w > q.w && is_open(p, q, dx, dy)) result.at(x, y) = p.w;
      }
    }
  }
  return result;
}

AlphaImage spread(const AlphaImage& rims, int passes) {
  AlphaImage result = rims;
  for (int pass = 0; pass < passes; ++pass) {
    const AlphaImage before = result;
    for (int y = 0; y < before.height; ++y) {
      for (int x = 0; x < before.width; ++x) {
        for (const auto& [dx, dy] : kEdgeNeighbours) {
          if (before.contains(x + dx, y + dy)) result.at(x, y) = std::max(result.at(x, y), before.at(x + dx, y + dy));
        }
      }
    }
  }
  return result;
}

Image<Cell> cells(const Image<Surface>& surfaces, const AlphaImage* unsafe, const Flags& usable) {
  Image<Cell> result(surfaces.width - 1, surfaces.height - 1);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const bool open = is_open(surfaces.at(x, y), surfaces.at(x + 1, y), 1, 0) ||
                        is_open(surfaces.at(x, y + 1), surfaces.at(x + 1, y + 1), 1, 0) ||
                        is_open(surfaces.at(x, y), surfaces.at(x, y + 1), 0, 1) ||
                        is_open(surfaces.at(x + 1, y), surfaces.at(x + 1, y + 1), 0, 1);
      bool all_usable = true;
      double least = 0, greatest = 0, greatest_unsafe = 0;
      for (const int i : {0, 1, 2, 3}) {
        const int dx = i % 2, dy = i / 2;
        const Surface& s = surfaces.at(x + dx, y + dy);
        all_usable = all_usable && usable.at(x + dx, y + dy) != 0;
        const double middle = s.continued(0.5 - dx, 0.5 - dy);
        const double half = 0.5 * (std::abs(s.a) + std::abs(s.b));
        const double low = s.range.keep(middle - half), high = s.range.keep(middle + half);
        least = i == 0 ? low : std::min(least, low);
        greatest = i == 0 ? high : std::max(greatest, high);
        if (unsafe != nullptr) greatest_unsafe = std::max(greatest_unsafe, unsafe->at(x + dx, y + dy));
      }
      if (!all_usable || greatest <= 0) continue;
      Cell& cell = result.at(x, y);
      cell.least = least * (1 - kBatchedRounding);
      cell.greatest = greatest * (1 + kBatchedRounding);
      const double safe_least = std::max(cell.least, (1 - kBatchedGap) * greatest_unsafe);
      cell.thin_only = open || safe_least > cell.greatest;
      if (!cell.thin_only) cell.least = safe_least;
    }
  }
  return result;
}

}  // namespace foreview::oracle
