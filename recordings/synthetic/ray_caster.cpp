#include "foreview/recordings/synthetic/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>

namespace foreview::synthetic {

RayCaster::RayCaster(std::vector<glm::vec3> triangle_corners) : corners_(std::move(triangle_corners)) {
  order_.resize(corners_.size() / 3);
  std::iota(order_.begin(), order_.end(), 0U);
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
}

std::uint32_t RayCaster::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  node.lower = glm::vec3(std::numeric_limits<float>::max());
  node.upper = -node.lower;
  glm::vec3 centre_lower = node.lower, centre_upper = node.upper;
  const auto centre = [&](std::uint32_t t) { return corners_[3 * t] + corners_[3 * t + 1] + corners_[3 * t + 2]; };
  for (std::uint32_t i = begin; i < end; ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      node.lower = glm::min(node.lower, corners_[3 * order_[i] + k]);
      node.upper = glm::max(node.upper, corners_[3 * order_[i] + k]);
    }
    centre_lower = glm::min(centre_lower, centre(order_[i]));
    centre_upper = glm::max(centre_upper, centre(order_[i]));
  }
  nodes_.push_back(node);
  if (end - begin <= 4) {
    nodes_[index].first = begin;
    nodes_[index].count = end - begin;
    return index;
  }
  const glm::vec3 extent = centre_upper - centre_lower;
  const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
  const std::uint32_t middle = (begin + end) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float ca = centre(a)[axis], cb = centre(b)[axis];
                     return ca < cb || (ca == cb && a < b);
                   });
  build(begin, middle);
  const std::uint32_t right = build(middle, end);
  nodes_[index].first = right;
  return index;
}

template <bool any>
float RayCaster::walk(const glm::vec3& origin, const glm::vec3& direction, float limit) const {
  if (nodes_.empty()) return limit;
  const glm::vec3 inverse{1 / direction.x, 1 / direction.y, 1 / direction.z};
  std::array<std::uint32_t, 64> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  float nearest = limit;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    const glm::vec3 t0 = (node.lower - origin) * inverse, t1 = (node.upper - origin) * inverse;
    const glm::vec3 low = glm::min(t0, t1), high = glm::max(t0, t1);
    const float enter = std::max(std::max(low.x, low.y), std::max(low.z, 0.0F));
    const float leave = std::min(std::min(high.x, high.y), std::min(high.z, nearest));
    if (!(enter <= leave)) continue;
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const glm::vec3* const c = &corners_[std::size_t{3} * order_[i]];
      const glm::vec3 e1 = c[1] - c[0], e2 = c[2] - c[0];
      const glm::vec3 p = glm::cross(direction, e2);
      const float determinant = glm::dot(e1, p);
      if (std::abs(determinant) < 1e-12F) continue;
      const float scale = 1 / determinant;
      const glm::vec3 s = origin - c[0];
      const float u = glm::dot(s, p) * scale;
      if (u < 0 || u > 1) continue;
      const glm::vec3 q = glm::cross(s, e1);
      const float v = glm::dot(direction, q) * scale;
      if (v < 0 || u + v > 1) continue;
      const float t = glm::dot(e2, q) * scale;
      if (t > 0 && t < nearest) {
        nearest = t;
        if constexpr (any) return nearest;
      }
    }
  }
  return nearest;
}

float RayCaster::distance(const glm::vec3& origin, const glm::vec3& direction, float limit) const {
  return walk<false>(origin, direction, limit);
}

bool RayCaster::blocked(const glm::vec3& origin, const glm::vec3& direction, float limit) const {
  return walk<true>(origin, direction, limit) < limit;
}

}  // namespace foreview::synthetic
