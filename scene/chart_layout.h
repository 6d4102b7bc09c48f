#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "foreview/scene/polygon_model.h"

namespace foreview {

/// The place of one polygon's texture (design 4): in the block of its group, a rectangle in an atlas page with one
/// affine texel map, fixed for life. The map projects along the normal of the group's plane: a polygon inclined to it
/// by an angle a gets cos(a) of the density along its slope.
struct Chart {
  std::uint32_t group = 0;  ///< index into ChartLayout::groups
  std::uint32_t page = 0;   ///< this and the next three as in the group
  glm::ivec2 origin{0, 0}, size{0, 0}, inner{0, 0};
  PolygonFrame frame;                 ///< of the group's plane and box, in the part's frame
  glm::dvec3 normal{0, 0, 1};         ///< the polygon's own plane, in the part's frame
  double offset = 0;                  ///< dot(normal, p) == offset on it, metres
  glm::dvec2 texels_per_metre{0, 0};  ///< along frame.x_axis and y_axis; they differ only where max_texels bounds one

  /// Continuous texel coordinates in the page ((0.5, 0.5) = centre of texel 0, 0) of a point in the part's frame,
  /// projected onto the group's plane.
  [[nodiscard]] glm::dvec2 texel_from_part(const glm::dvec3& p) const;
  /// The point of the polygon's own plane that is projected there.
  [[nodiscard]] glm::dvec3 part_from_texel(const glm::dvec2& texel) const;
};

/// One polygon, or several neighbours that share a block without overlapping (see group_polygons()). Origin and size
/// are multiples of kChartAlignment, so that mip levels 0..kChartLevels-1 of different groups never share a texel.
struct ChartGroup {
  std::uint32_t page = 0;
  glm::ivec2 origin{0, 0};         ///< texels, upper left of the block in the page
  glm::ivec2 size{0, 0};           ///< texels of the block, multiples of kChartAlignment
  glm::ivec2 inner{0, 0};          ///< texels that the group's box spans, rounded up; it begins at kChartGutter
  std::uint32_t first_member = 0;  ///< into ChartLayout::members
  std::uint32_t member_count = 0;  ///< >= 1
};

inline constexpr int kChartAlignment = 16;  ///< texels
inline constexpr int kChartLevels = 5;      ///< mip levels 0..4: one coarsest texel covers 16
inline constexpr int kChartGutter = 2;      ///< texels beyond a group's outline that also get the picture's colours

struct ChartOptions {
  double texels_per_metre = 500;                     ///< spec 6: d
  int max_texels = 256;                              ///< spec 6: r_max, of one block along an axis, gutter not counted
  int page_size = 4096;                              ///< texels; lowered to the driver's limit by the caller
  std::size_t memory_budget = std::size_t{2} << 30;  ///< bytes of all pages with levels; densities are lowered to fit
  bool group_polygons = true;                        ///< false: every polygon has a block of its own
};

struct ChartLayout {
  int page_size = 0;
  std::uint32_t pages = 0;
  std::vector<Chart> charts;  ///< one per polygon, same order
  std::vector<ChartGroup> groups;
  std::vector<std::uint32_t> members;  ///< all polygons, by group, ascending inside each
  /// One per entry of PolygonModel::corners(): whether the edge from that corner to the polygon's next one lies on the
  /// outline of the polygon's group, where a gutter is needed. Where the outline turns inwards, the gutter of one
  /// member may reach over texels of another, whose own they stay.
  std::vector<bool> outline;
  /// The polygons of a group.
  [[nodiscard]] std::span<const std::uint32_t> members_of(const ChartGroup& group) const {
    return std::span(members).subspan(group.first_member, group.member_count);
  }
  // Figures for `inspect`. The first two leave out the backdrop, whose large squares would flatter them:
  double useful_texels = 0;   ///< area of all polygons in texels, as projected
  double written_texels = 0;  ///< texels whose centre lies in a group's outline grown by the gutter (by area)
  std::size_t allocated_texels = 0;
  std::size_t memory_bytes = 0;      ///< of the pages, all levels, 4 bytes a texel
  std::size_t polygons_capped = 0;   ///< that max_texels made coarser than wanted
  std::size_t polygons_lowered = 0;  ///< that the memory budget made coarser
  std::vector<std::string> notes;    ///< what was lowered and why, one line each
};

/// Lays the charts out, deterministically. Backdrop polygons get options of the import: their density is
/// texels-per-radian over distance and comes with the polygon's size (a backdrop polygon always spans
/// `backdrop_max_texels` along its longer axis). Throws InputError if not even the smallest density fits.
[[nodiscard]] ChartLayout lay_out_charts(const PolygonModel& model, const ChartOptions& options);

}  // namespace foreview
