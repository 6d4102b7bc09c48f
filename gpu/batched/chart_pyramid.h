#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "foreview/gpu/batched/chart_tables.h"
#include "foreview/gpu/batched/page_targets.h"
#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::batched {

/// Rules 6 to 8 of BatchedExtraction: fills the holes of charts and makes their levels, from the pyramids of what was
/// observed in them.
class ChartPyramid {
 public:
  ChartPyramid(const TextureStore& store, const ChartTables& tables, PatchLists& patches, PageTargets& pages);
  void clear();
  enum class Pull {
    show,         ///< the pages' levels 1 to 3 get what needs no filling
    leave_pages,  ///< as they are
  };
  /// Rule 6 for the touched patches, then for `charts` up to their tips.
  void pull(const std::vector<std::uint32_t>& charts, Pull how = Pull::show);

  // A picture in pieces. All that follow come in this order, each for all that it goes over in any number of calls.

  /// Which charts it concerns.
  void list(const std::vector<std::uint32_t>& charts);
  [[nodiscard]] std::size_t charts() const { return charts_; }
  static constexpr int kPatchLevels = kChartLevels - 1;  ///< 1 to 4 are pulled patch by patch
  /// Rule 6 up to level 4, from level 1 on: the touched patches, all of them, or a run of their list.
  void pull_level(int level, Pull how, const std::optional<Run>& patches);
  /// Of rules 6 and 7, what goes over charts: level 5 to the tip up, and then down to 4.
  [[nodiscard]] int tip_passes() const;
  void draw_tip(int pass, const Run& charts);
  /// Rule 7: which patches must be filled anew. PatchLists::begin() must have named the charts, too.
  void renew(const Run& candidates);
  /// Then from level 3 down to 0: the patches to be filled anew, at level 0 those with holes.
  void push_level(int level, const std::optional<Run>& patches);
  /// Rule 8, for all polygons.
  void write_states(GLuint polygon_states);
  /// What was observed, in the pages' layout; level 1..4.
  [[nodiscard]] GLuint observed(int level) const { return pulled_[static_cast<std::size_t>(level)].texture.id(); }
  /// CV_8UC4 BGRA, one a page; level 1..4.
  [[nodiscard]] std::vector<cv::Mat> read_pulled(int level) const;

 private:
  struct Texture {
    GlTexture texture;
    LayerTargets targets;
    int width = 0, height = 0, layers = 0;
  };
  [[nodiscard]] Texture make(int level) const;
  void draw_charts(int level, int other_level, const Texture& into, const Run& charts);

  const TextureStore& store_;
  const ChartTables& tables_;
  PatchLists& patches_;
  PageTargets& pages_;
  GlProgram pull_, pull_tip_, push_tip_, push_last_, push_, push_base_, states_;
  /// By level, up to the tip: what was observed (from 1 on), and the fill (from 4 on). Up to 4 in the pages' layout.
  std::vector<Texture> pulled_, filled_;
  GlBuffer chart_list_;
  GlVertexArray no_vertices_;
  GlSampler linear_;
  std::size_t charts_ = 0;
};

}  // namespace foreview::batched
