#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "foreview/scene/polygon_model.h"

namespace foreview {

/// A chart (design 4): the texture of one polygon, a rectangle in an atlas page with one affine texel map, fixed for
/// life. Origin and size are multiples of kChartAlignment, so that mip levels 0..kChartLevels-1 of different charts
/// never share a texel.
struct Chart {
  std::uint32_t page = 0;
  glm::ivec2 origin{0, 0};  ///< texels, upper left of the block in the page
  glm::ivec2 size{0, 0};    ///< texels of the block, multiples of kChartAlignment
  glm::ivec2 inner{0, 0};   ///< texels that the polygon's box spans, rounded up; it begins at kChartGutter
  PolygonFrame frame;
  glm::dvec2 texels_per_metre{0, 0};  ///< along frame.x_axis and y_axis; they differ only where max_texels bounds one

  /// Continuous texel coordinates in the page ((0.5, 0.5) = centre of texel 0, 0) of a point in the part's frame.
  [[nodiscard]] glm::dvec2 texel_from_part(const glm::dvec3& p) const;
  [[nodiscard]] glm::dvec3 part_from_texel(const glm::dvec2& texel) const;
};

inline constexpr int kChartAlignment = 16;  ///< texels
inline constexpr int kChartLevels = 5;      ///< mip levels 0..4: one coarsest texel covers 16
inline constexpr int kChartGutter = 2;      ///< texels around the polygon's box that also get the picture's colours

struct ChartOptions {
  double texels_per_metre = 500;                     ///< spec 6: d
  int max_texels = 256;                              ///< spec 6: r_max, of one chart along an axis, gutter not counted
  int page_size = 4096;                              ///< texels; lowered to the driver's limit by the caller
  std::size_t memory_budget = std::size_t{2} << 30;  ///< bytes of all pages with levels; densities are lowered to fit
};

struct ChartLayout {
  int page_size = 0;
  std::uint32_t pages = 0;
  std::vector<Chart> charts;  ///< one per polygon, same order
  // Figures for `inspect`. The first two leave out the backdrop, whose large squares would flatter them:
  double useful_texels = 0;   ///< area of all polygons times density
  double written_texels = 0;  ///< texels whose centre lies in a polygon grown by the gutter (by area, not counted)
  std::size_t allocated_texels = 0;
  std::size_t memory_bytes = 0;      ///< of the pages, all levels, 4 bytes a texel
  std::size_t polygons_capped = 0;   ///< charts that max_texels made coarser than wanted
  std::size_t polygons_lowered = 0;  ///< charts that the memory budget made coarser
  std::vector<std::string> notes;    ///< what was lowered and why, one line each
};

/// Lays the charts out, deterministically. Backdrop polygons get options of the import: their density is
/// texels-per-radian over distance and comes with the polygon's size (a backdrop polygon always spans
/// `backdrop_max_texels` along its longer axis). Throws InputError if not even the smallest density fits.
[[nodiscard]] ChartLayout lay_out_charts(const PolygonModel& model, const ChartOptions& options);

}  // namespace foreview
