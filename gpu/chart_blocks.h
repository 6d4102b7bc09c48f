#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/chart_layout.h"

namespace foreview {

/// Blocks of kChartAlignment x kChartAlignment texels of charts, for compute programs with one workgroup a block
/// (shaders that include chart_blocks.glsl).
class ChartBlocks {
 public:
  /// Room for all blocks of the layout, which must outlive this. Needs a current context.
  explicit ChartBlocks(const ChartLayout& layout);
  /// The blocks of these groups; what was listed before is forgotten.
  void list(const std::vector<std::uint32_t>& groups);
  [[nodiscard]] bool empty() const { return blocks_.empty(); }
  /// Runs the current program, which must have been bound what it needs but the list, over all listed blocks.
  void dispatch() const { dispatch(0, blocks_.size()); }
  /// The same over some of them.
  void dispatch(std::size_t first, std::size_t count) const;
  [[nodiscard]] std::size_t size() const { return blocks_.size(); }

 private:
  const ChartLayout& layout_;
  GlBuffer buffer_;
  std::vector<std::uint32_t> blocks_;
};

}  // namespace foreview
