#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/scene/timestamp.h"

namespace foreview {

/// What is known of a polygon and its texture, for the operator who points at it.
struct PolygonReport {
  std::uint32_t polygon = 0;
  std::string part;
  std::size_t corners = 0;
  double area = 0;  ///< square metres
  bool is_backdrop = false;
  std::uint32_t group = 0;           ///< ChartLayout::groups: the chart
  std::uint32_t group_polygons = 0;  ///< that share it
  std::uint32_t page = 0;
  glm::ivec2 origin{0, 0}, size{0, 0};  ///< texels: the chart's block in the page
  glm::dvec2 texels_per_metre{0, 0};

  // Of the texels whose centre lies in the polygon; 0 where it has none.
  std::size_t texels = 0;
  double observed_share = 0;  ///< shown by some picture; the others are filled from around
  /// When the colours of its blocks of texels were captured, newest first, and how large a share of the blocks that is;
  /// at most kMostCaptures, older ones are left out. Rounded to milliseconds. Empty: never, or not known.
  struct Capture {
    Timestamp stamp;
    double share = 0;
    bool operator==(const Capture&) const = default;
  };
  static constexpr std::size_t kMostCaptures = 8;
  std::vector<Capture> captures;
  /// Numbers of the pictures (TextureStore::Shown::picture) that changed its newest capture while it was looked at,
  /// newest first, at most kMostCaptures.
  std::vector<std::uint64_t> changed_by;
};

/// What model and layout say; the rest is left as it is.
[[nodiscard]] PolygonReport describe_polygon(const PolygonModel& model, const ChartLayout& layout,
                                             std::uint32_t polygon);

/// The texels of a page that a polygon lies in.
struct TexelBox {
  glm::ivec2 first{0, 0}, size{0, 0};
};
[[nodiscard]] TexelBox texel_box(const PolygonModel& model, const ChartLayout& layout, std::uint32_t polygon);

/// Fills in texels, shares and captures. `texels` are the box's from level 0 (CV_8UC4); `times` those of the blocks of
/// kChartAlignment texels that the box touches (CV_32S, milliseconds since epoch, kNeverCaptured), as rows and columns
/// of blocks.
void count_texels(PolygonReport& report, const PolygonModel& model, const ChartLayout& layout, const cv::Mat& texels,
                  const cv::Mat& times, Timestamp epoch);

}  // namespace foreview
