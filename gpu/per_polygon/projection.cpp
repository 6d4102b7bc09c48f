#include "foreview/gpu/per_polygon/projection.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview::per_polygon {

namespace {

constexpr double kGrow = 3;            // pixels
constexpr double kRounding = 1e-6;     // pixels
constexpr double kLeastArea = 0.05;    // square pixels
constexpr double kLeastEdge = 1e-6;    // pixels
constexpr double kLeastOffset = 1e-9;  // metres from the camera to a plane, below which the plane is seen edge-on

/// Keeps the part of a convex polygon where `inside` (a signed distance, affine in the point) is not negative.
template <typename Point, typename Distance>
void clip(const std::vector<Point>& polygon, std::vector<Point>& result, const Distance& inside) {
  result.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& from = polygon[i];
    const Point& to = polygon[(i + 1) % polygon.size()];
    const double a = inside(from), b = inside(to);
    if (a >= 0) result.push_back(from);
    if ((a >= 0) != (b >= 0)) result.push_back(from + (to - from) * (a / (a - b)));
  }
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

double signed_area(const std::vector<glm::dvec2>& polygon) {
  // Relative to a corner: far coordinates would cancel badly.
  double twice = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    twice += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  }
  return twice / 2;
}

/// Whole pixels between two coordinates, cut to 0..size; (0, 0) or an empty range where none is left.
std::pair<int, int> pixel_range(double least, double greatest, int size) {
  if (!(least < greatest)) return {0, 0};  // nothing, or not numbers
  const double from = std::clamp(std::floor(least), 0.0, static_cast<double>(size));
  const double to = std::clamp(std::ceil(greatest), 0.0, static_cast<double>(size));
  return {static_cast<int>(from), static_cast<int>(to)};
}

}  // namespace

void Projector::project(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal, double offset,
                        ProjectedPolygon& result) {
  result.box = {};
  result.shorter_side = 0;
  result.outline.clear();
  result.fate = Fate::outside;
  result.reference = {0, 0};
  result.inverse_z_slope = {0, 0};
  result.inverse_z_at_reference = result.least_inverse_z = result.greatest_inverse_z = 0;

  clip(corners, clipped_, [this](const glm::dvec3& p) { return p.z - near_; });
  projected_.clear();
  double least_u = std::numeric_limits<double>::infinity(), greatest_u = -least_u, least_v = least_u,
         greatest_v = -least_u;
  result.least_inverse_z = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& p : clipped_) {
    const glm::dvec2 pixel = glm::dvec2(p) / p.z * camera_.focal_length + camera_.principal_point;
    projected_.push_back(pixel);
    least_u = std::min(least_u, pixel.x);
    greatest_u = std::max(greatest_u, pixel.x);
    least_v = std::min(least_v, pixel.y);
    greatest_v = std::max(greatest_v, pixel.y);
    result.least_inverse_z = std::min(result.least_inverse_z, 1 / p.z);
    result.greatest_inverse_z = std::max(result.greatest_inverse_z, 1 / p.z);
  }
  const bool back_face = !(offset < 0);
  if (projected_.size() < 3) {
    result.least_inverse_z = 0;
    result.fate = back_face ? Fate::back_face : Fate::outside;
    return;
  }

  // The box, before and after growing.
  const auto [x0, x1] = pixel_range(least_u + kRounding, greatest_u - kRounding, camera_.width);
  const auto [y0, y1] = pixel_range(least_v + kRounding, greatest_v - kRounding, camera_.height);
  const bool outside = x0 >= x1 || y0 >= y1;
  if (!outside) {
    result.shorter_side = std::min(x1 - x0, y1 - y0);
    const auto [left, right] = pixel_range(least_u + kRounding - kGrow, greatest_u - kRounding + kGrow, camera_.width);
    const auto [top, bottom] = pixel_range(least_v + kRounding - kGrow, greatest_v - kRounding + kGrow, camera_.height);
    result.box = {left, top, right - left, bottom - top};
    result.reference = {left + 0.5 * (right - left), top + 0.5 * (bottom - top)};
  }

  if (std::abs(offset) > kLeastOffset) {
    const glm::dvec2 straight = (result.reference - camera_.principal_point) / camera_.focal_length;
    result.inverse_z_slope = glm::dvec2(normal) / (offset * camera_.focal_length);
    result.inverse_z_at_reference = glm::dot(normal, glm::dvec3(straight, 1)) / offset;
  } else {
    result.inverse_z_at_reference = result.greatest_inverse_z;
  }

  if (back_face) {
    result.fate = Fate::back_face;
    return;
  }
  if (outside) return;
  const double area = signed_area(projected_);
  if (!(std::abs(area) >= kLeastArea)) {
    result.fate = Fate::too_small;
    return;
  }
  result.fate = Fate::visible;

  const double left = result.box.x - kOutlineMargin, right = result.box.x + result.box.width + kOutlineMargin;
  const double top = result.box.y - kOutlineMargin, bottom = result.box.y + result.box.height + kOutlineMargin;
  clip(projected_, scratch_, [&](const glm::dvec2& p) { return p.x - left; });
  clip(scratch_, projected_, [&](const glm::dvec2& p) { return right - p.x; });
  clip(projected_, scratch_, [&](const glm::dvec2& p) { return p.y - top; });
  clip(scratch_, projected_, [&](const glm::dvec2& p) { return bottom - p.y; });
  if (projected_.size() < 3) return;
  if (area < 0) std::reverse(projected_.begin(), projected_.end());
  for (std::size_t i = 0; i < projected_.size(); ++i) {
    const glm::dvec2 from = projected_[i], along = projected_[(i + 1) % projected_.size()] - from;
    const double length = glm::length(along);
    if (length < kLeastEdge) continue;
    result.outline.push_back({from - result.reference, along / length, length});
  }
}

}  // namespace foreview::per_polygon
