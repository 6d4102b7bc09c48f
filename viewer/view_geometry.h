#pragma once
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// A model and its charts as the predicted view draws them: plain arrays for vertex and storage buffers.
struct ViewGeometry {
  /// A corner of a polygon. Positions are relative to their part's centre and texels to their chart's origin, so that
  /// single precision is enough wherever the model lies and however large the pages are.
  struct Vertex {
    glm::vec3 position{0};  ///< metres, part frame minus part_centres[part]
    glm::vec2 texel{0};     ///< texels from the chart's origin
    std::uint32_t polygon = 0;
    std::uint32_t part = 0;
  };
  /// A chart as the fragment shader reads it (std430): where it is, and where in it colours are.
  struct ChartRecord {
    glm::vec2 origin{0};  ///< texels, of the block in the page
    glm::vec2 size{0};    ///< texels, of the block
    glm::vec2 valid{0};   ///< texels: the polygon's box grown by the gutter on both sides, from the block's origin
    float page = 0;
    float group = 0;  ///< index into ChartLayout::groups; exact, there are fewer than 2^24
  };
  static_assert(sizeof(Vertex) == 28 && sizeof(ChartRecord) == 32);

  std::vector<Vertex> vertices;          ///< one per corner of a polygon
  std::vector<std::uint32_t> triangles;  ///< fans, three indices of `vertices` each, in the order of the polygons
  std::vector<std::uint32_t> edges;      ///< two indices each: polygons' edges, shared ones once, backdrop left out
  std::vector<ChartRecord> charts;       ///< one per polygon
  std::vector<glm::dvec3> part_centres;  ///< one per part, part frame
  std::vector<bool> part_is_backdrop;    ///< one per part: has nothing but backdrop (or nothing at all)

  ViewGeometry() = default;
  ViewGeometry(const PolygonModel& model, const ChartLayout& layout);
};

/// The camera whose picture fills `width` x `height` pixels: scaled to the height, aspect kept, centred; a wider
/// viewport shows more to the left and right, a narrower one less.
[[nodiscard]] CameraModel fit_camera(const CameraModel& camera, int width, int height);

}  // namespace foreview
