#include "foreview/scene/ray_caster.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview {
namespace {

constexpr std::size_t kLeaf = 4;    ///< polygons
constexpr std::size_t kDepth = 64;  ///< halving 2^32 polygons ends sooner
constexpr double kPadding = 1e-9;   ///< metres, for what rounding may do

/// Whether origin + s * direction is in the box for some s in 0..limit.
bool crosses(const glm::dvec3& lower, const glm::dvec3& upper, const glm::dvec3& origin, const glm::dvec3& inverse,
             double limit) {
  double from = 0, to = limit;
  for (int i = 0; i < 3; ++i) {
    const double a = (lower[i] - origin[i]) * inverse[i], b = (upper[i] - origin[i]) * inverse[i];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

}  // namespace

RayCaster::RayCaster(const PolygonModel& model) : model_(model) {
  const std::size_t count = model.polygons().size();
  std::vector<glm::dvec3> lower(count, glm::dvec3(std::numeric_limits<double>::infinity()));
  std::vector<glm::dvec3> upper(count, glm::dvec3(-std::numeric_limits<double>::infinity()));
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::uint32_t corner : model.corners_of(i)) {
      lower[i] = glm::min(lower[i], model.vertices()[corner] - kPadding);
      upper[i] = glm::max(upper[i], model.vertices()[corner] + kPadding);
    }
    if (!model.polygons()[i].is_backdrop) order_.push_back(static_cast<std::uint32_t>(i));
  }
  std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return model.polygons()[a].part < model.polygons()[b].part;
  });
  for (std::size_t begin = 0; begin < order_.size();) {
    const std::uint32_t part = model.polygons()[order_[begin]].part;
    std::size_t end = begin;
    while (end < order_.size() && model.polygons()[order_[end]].part == part) ++end;
    roots_.push_back({part, build(begin, end, lower, upper)});
    begin = end;
  }
}

std::uint32_t RayCaster::build(std::size_t begin, std::size_t end, const std::vector<glm::dvec3>& lower,
                               const std::vector<glm::dvec3>& upper) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Node node{lower[order_[begin]], upper[order_[begin]], static_cast<std::uint32_t>(begin), 0, 0};
  for (std::size_t i = begin; i < end; ++i) {
    node.lower = glm::min(node.lower, lower[order_[i]]);
    node.upper = glm::max(node.upper, upper[order_[i]]);
  }
  if (end - begin <= kLeaf) {
    node.count = static_cast<std::uint32_t>(end - begin);
  } else {
    const glm::dvec3 extent = node.upper - node.lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      return lower[a][axis] + upper[a][axis] < lower[b][axis] + upper[b][axis];
    });
    build(begin, middle, lower, upper);
    node.second = build(middle, end, lower, upper);
  }
  nodes_[index] = node;
  return index;
}

bool RayCaster::meets(std::size_t polygon, const glm::dvec3& point) const {
  const std::size_t corners = model_.polygons()[polygon].corner_count;
  for (std::size_t i = 0; i < corners; ++i) {
    const glm::dvec3 &a = model_.corner(polygon, i), &b = model_.corner(polygon, (i + 1) % corners);
    if (glm::dot(glm::cross(b - a, point - a), model_.polygons()[polygon].normal) < 0) return false;
  }
  return true;
}

std::optional<RayCaster::Hit> RayCaster::nearest(const glm::dvec3& origin, const glm::dvec3& direction,
                                                 std::span<const Pose> world_from_part, double limit) const {
  std::optional<Hit> hit;
  std::array<std::uint32_t, kDepth> waiting{};
  for (const Root& root : roots_) {
    const Pose part_from_world = world_from_part[root.part].inverse();
    const glm::dvec3 from = part_from_world * origin, along = part_from_world.rotate(direction);
    glm::dvec3 inverse(0);
    for (int i = 0; i < 3; ++i) inverse[i] = along[i] != 0 ? 1 / along[i] : std::numeric_limits<double>::max();
    std::size_t depth = 0;
    waiting[depth++] = root.node;
    while (depth > 0) {
      const std::uint32_t index = waiting[--depth];
      const Node& node = nodes_[index];
      if (!crosses(node.lower, node.upper, from, inverse, limit)) continue;
      if (node.count == 0) {
        waiting[depth++] = node.second;
        waiting[depth++] = index + 1;
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Polygon& polygon = model_.polygons()[order_[i]];
        const double distance = (polygon.offset - glm::dot(polygon.normal, from)) / glm::dot(polygon.normal, along);
        if (distance > 0 && distance < limit && meets(order_[i], from + distance * along)) {
          limit = distance;
          hit = Hit{order_[i], distance};
        }
      }
    }
  }
  return hit;
}

}  // namespace foreview
