#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::batched {

/// Texels along the side of a patch: a chart is cut into such squares, each of which is extracted and filled, or left
/// alone, as a whole. 32 measured best of 16, 32 and 64.
inline constexpr int kPatchTexels = 32;

/// How many patches a chart's block has along x and y.
[[nodiscard]] inline glm::ivec2 patch_grid(const glm::ivec2& block_size) {
  return (block_size + (kPatchTexels - 1)) / kPatchTexels;
}

/// The model twice, made once: its polygons as they lie in space, and as they lie in their charts, grown by the gutter
/// where an edge is the chart's outline and cut along the borders of patches. Vertices carry both places; positions are
/// relative to their part's centre, so that floats suffice.
class ChartGeometry {
 public:
  /// Needs a current context.
  ChartGeometry(const PolygonModel& model, const ChartLayout& layout);

  /// A range of indices or of patches.
  struct Range {
    std::uint32_t first = 0, count = 0;
  };
  /// A square of a chart.
  struct Patch {
    glm::dvec3 centre{0};  ///< of a ball around all polygons' parts in it; metres, part frame
    double radius = -1;    ///< negative: no polygon reaches into it
    double texels = 0;     ///< of polygons and gutters in it, by area
    std::uint32_t chart = 0, part = 0;
    glm::ivec2 origin{0}, size{0};  ///< texels in the page
  };

  /// Attributes 0 position, 1 polygon, 2 part, 3 texel in the page, 4 patch; no index buffer bound.
  [[nodiscard]] GLuint vertex_array() const { return vertex_array_.id(); }
  /// Vertices of a polygon, in order, as it lies in space: a fan.
  [[nodiscard]] const Range& corners(std::size_t polygon) const { return corners_[polygon]; }
  /// Of all polygons' fans as triangles.
  [[nodiscard]] std::size_t scene_index_count() const { return scene_index_count_; }
  /// Triangles in the charts: of a polygon itself, and of the gutter along its edges.
  [[nodiscard]] const std::vector<std::uint32_t>& chart_indices() const { return chart_indices_; }
  [[nodiscard]] const Range& own_triangles(std::size_t polygon) const { return own_[polygon]; }
  [[nodiscard]] const Range& gutter_triangles(std::size_t polygon) const { return gutter_[polygon]; }
  /// The same triangles by the patch that they lie in: consecutive ranges of chart_indices().
  struct Piece {
    std::uint32_t patch = 0;
    Range indices;
    float texels = 0;  ///< by area
  };
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  /// Ranges of pieces().
  [[nodiscard]] const Range& own_pieces(std::size_t polygon) const { return own_pieces_[polygon]; }
  [[nodiscard]] const Range& gutter_pieces(std::size_t polygon) const { return gutter_pieces_[polygon]; }
  /// By chart (ChartLayout::groups), row by row.
  [[nodiscard]] const std::vector<Patch>& patches() const { return patches_; }
  [[nodiscard]] const Range& patches_of(std::size_t chart) const { return patches_of_[chart]; }
  /// Texels of the polygon and its gutter, by area.
  [[nodiscard]] float texels(std::size_t polygon) const { return texels_[polygon]; }
  [[nodiscard]] const glm::dvec3& part_centre(std::size_t part) const { return part_centres_[part]; }

 private:
  struct Vertex {
    glm::vec3 position;
    std::uint32_t polygon, part, patch;
    glm::vec2 texel;
  };
  void add_patches(const ChartLayout& layout);
  struct Box {
    glm::dvec3 lower{1e300}, upper{-1e300};
  };
  struct Making {
    std::vector<Vertex> vertices;
    std::vector<Box> boxes;  ///< by patch, part frame
  };
  void add_shape(Making& making, const std::vector<glm::dvec2>& shape, std::uint32_t polygon, const Chart& chart,
                 std::uint32_t part);

  std::vector<glm::dvec3> part_centres_;
  std::size_t scene_index_count_ = 0;
  std::vector<std::uint32_t> chart_indices_;
  std::vector<Range> corners_, own_, gutter_, patches_of_, own_pieces_, gutter_pieces_;
  std::vector<Piece> pieces_;
  std::vector<Patch> patches_;
  std::vector<float> texels_;
  GlVertexArray vertex_array_;
  GlBuffer vertices_;
};

}  // namespace foreview::batched
