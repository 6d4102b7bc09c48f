#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "foreview/scene/polygon_model.h"
#include "foreview/scene/pose.h"

namespace foreview {

/// Where lines of sight meet a model, without a GPU: a tree of boxes around the polygons of each part, made once;
/// moving parts costs nothing. Backdrops are not met. The model must outlive it. Const members may be called by several
/// threads.
class RayCaster {
 public:
  explicit RayCaster(const PolygonModel& model);

  struct Hit {
    std::uint32_t polygon = 0;
    double distance = 0;  ///< in multiples of the ray's direction
  };
  /// The nearest polygon, front or back, that origin + s * direction (world frame, metres) meets at 0 < s < `limit`.
  /// `world_from_part`: of every part of the model.
  [[nodiscard]] std::optional<Hit> nearest(const glm::dvec3& origin, const glm::dvec3& direction,
                                           std::span<const Pose> world_from_part, double limit) const;

 private:
  /// Inner nodes have their first child behind them and the second at `second`; leaves hold `count` of order_.
  struct Node {
    glm::dvec3 lower{0}, upper{0};  ///< part frame
    std::uint32_t first = 0, count = 0, second = 0;
  };
  std::uint32_t build(std::size_t begin, std::size_t end, const std::vector<glm::dvec3>& lower,
                      const std::vector<glm::dvec3>& upper);
  [[nodiscard]] bool meets(std::size_t polygon, const glm::dvec3& point) const;

  const PolygonModel& model_;
  std::vector<std::uint32_t> order_;  ///< polygons, as the leaves have them
  std::vector<Node> nodes_;
  struct Root {
    std::uint32_t part = 0, node = 0;
  };
  std::vector<Root> roots_;
};

}  // namespace foreview
