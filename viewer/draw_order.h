#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "foreview/scene/pose.h"
#include "foreview/viewer/view_geometry.h"

namespace foreview {

/// Triangles of a model, the polygons roughly nearest to the camera first: what is drawn first hides the rest, which
/// then costs no colour. (With one sample a pixel, that halves a frame in software; with four it saves nothing there.)
/// Sorts into buckets of distance, not completely; allocates nothing after construction.
class DrawOrder {
 public:
  explicit DrawOrder(const ViewGeometry& geometry);
  /// Indices of ViewGeometry::vertices, all of ViewGeometry::triangles. Valid until the next call.
  [[nodiscard]] std::span<const std::uint32_t> front_to_back(const Pose& world_from_camera,
                                                             std::span<const Pose> world_from_part);

 private:
  struct Ball {
    glm::vec3 centre{0};  ///< metres, from the part's centre
    float radius = 0;
    std::uint32_t part = 0;
    std::uint32_t first = 0, count = 0;  ///< into ViewGeometry::triangles
  };
  static constexpr std::size_t kBuckets = 256;

  const std::vector<std::uint32_t>& triangles_;
  const std::vector<glm::dvec3>& part_centres_;
  std::vector<Ball> balls_;
  std::vector<std::uint32_t> sorted_;
  std::vector<std::uint8_t> bucket_;  ///< of each ball
  struct Row {
    glm::vec3 forward{0};  ///< camera's axis in the part's frame
    float offset = 0;
  };
  std::vector<Row> rows_;  ///< of each part: distance along the camera's axis
  std::array<std::uint32_t, kBuckets> ends_{};
};

}  // namespace foreview
