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
  };
  [[nodiscard]] Gathered gather_group(std::size_t group, const CameraFrame& frame, const ColourImage& colour,
                                      const Image<Cell>& cells) const;
  /// Rule 5's fusion: newest wins.
  void fuse_group(std::size_t group, Timestamp stamp, const Gathered& gathered);
  /// look(), gather_group() and fuse_group() of every group.
  void extract(const CameraFrame& frame);

  /// Level 0 of a group's block: what is observed.
  [[nodiscard]] const Texture& observed(std::size_t group) const { return charts_[group].observed; }
  [[nodiscard]] static bool any_observed(const Texture& texture);

 private:
  struct ChartState {
    Texture observed;
    std::optional<Timestamp> newest;
  };
  const PolygonModel& model_;
  const ChartLayout& layout_;
  BatchedOptions options_;
  std::vector<ChartState> charts_;
};

}  // namespace foreview::oracle
