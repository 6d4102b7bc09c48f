#pragma once
#include <cstdint>
#include <vector>

#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/chart_layout.h"

namespace foreview::batched {

/// What shaders know of charts and patches, made once (batched_patches.glsl, batched_charts.glsl, batched_tip.glsl),
/// and where charts lie at the levels above those of the pages.
class ChartTables {
 public:
  ChartTables(const ChartLayout& layout, const ChartGeometry& geometry);

  /// The level at which every chart is a single texel: 5 or more.
  [[nodiscard]] int tip_level() const { return tip_level_; }
  /// Texels of the texture that holds all charts at a level above 4.
  [[nodiscard]] glm::ivec2 tip_size(int level) const { return tip_sizes_[static_cast<std::size_t>(level - 5)]; }
  /// Binds the tables that never change (2, 7, 8, 10).
  void bind() const;

 private:
  void lay_out_tip(const ChartLayout& layout);

  int tip_level_ = 4;
  std::vector<glm::ivec2> tip_sizes_;
  GlBuffer patches_, charts_, tip_rects_, members_;
};

}  // namespace foreview::batched
