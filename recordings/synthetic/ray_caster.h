#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace foreview::synthetic {

/// Casts rays at a fixed set of triangles: shadows and ambient occlusion of what does not move. A tree of boxes.
class RayCaster {
 public:
  /// Three vertices per triangle, metres.
  explicit RayCaster(std::vector<glm::vec3> triangle_corners);

  /// Distance along the unit `direction` to the first hit within `limit` metres, either side of a triangle; `limit`
  /// where nothing is hit.
  [[nodiscard]] float distance(const glm::vec3& origin, const glm::vec3& direction, float limit) const;
  /// Whether anything lies within `limit`.
  [[nodiscard]] bool blocked(const glm::vec3& origin, const glm::vec3& direction, float limit) const;

 private:
  struct Node {
    glm::vec3 lower{0}, upper{0};
    std::uint32_t first = 0;  ///< triangle of a leaf, or the right child; the left child follows its parent
    std::uint32_t count = 0;  ///< triangles of a leaf; 0: inner node
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  template <bool any>
  float walk(const glm::vec3& origin, const glm::vec3& direction, float limit) const;

  std::vector<glm::vec3> corners_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace foreview::synthetic
