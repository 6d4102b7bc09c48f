#pragma once
#include <optional>
#include <vector>

#include "foreview/scene/chart_layout.h"
#include "oracle/batched_filling.h"
#include "oracle/batched_gather.h"
#include "oracle/undistortion.h"

namespace foreview::oracle {

struct BatchedOptions {
  int passes = 3;  ///< 0: no suppression
  double near_plane = 0.02;
};

/// What BatchedExtraction knows of a picture before it looks at any texel: rules 0 to 4.
struct BatchedPicture {
  UndistortedPicture picture;
  Image<Surface> surfaces;
  AlphaImage unsafe;
  Image<Cell> cells;
};

/// All rules, over any number of pictures.
class BatchedExtractionOracle {
 public:
  BatchedExtractionOracle(const PolygonModel& model, const ChartLayout& layout, const BatchedOptions& options);

  [[nodiscard]] BatchedPicture look(const CameraFrame& frame) const;
  /// Rule 5 without fusion: each texel of a group's block, given the cells and the picture (GL's, or look()'s).
  struct Gathered {
    Image<TexelOwner> owners;
    Image<GatheredTexel> texels;
    bool shown = false;  ///< a front of the chart's was in the picture
  };
  [[nodiscard]] Gathered gather_group(std::size_t group, const CameraFrame& frame, const ColourImage& colour,
                                      const Image<Cell>& cells) const;
  /// Whether a newer picture than this has shown the chart.
  [[nodiscard]] bool is_late(std::size_t group, Timestamp stamp) const;
  /// Rule 5's fusion: newest wins.
  void fuse_group(std::size_t group, Timestamp stamp, const Gathered& gathered);
  /// Rules 6 and 7: the colours of levels 0 to 4, the observed ones of level 0 as they are. Only where any is.
  [[nodiscard]] std::vector<ColourImage> fill_group(std::size_t group);

  /// Level 0 of a group's block: what is observed.
  [[nodiscard]] const Texture& observed(std::size_t group) const { return charts_[group].observed; }
  [[nodiscard]] static bool any_observed(const Texture& texture);

 private:
  struct ChartState {
    Texture observed;
    std::optional<Timestamp> newest;
    std::optional<FourthLevel> fourth_level;  ///< as it was shown last
  };
  const PolygonModel& model_;
  const ChartLayout& layout_;
  BatchedOptions options_;
  std::vector<ChartState> charts_;
};

}  // namespace foreview::oracle
