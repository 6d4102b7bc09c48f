#pragma once
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"
#include "oracle/batched_contours.h"
#include "oracle/image.h"

// Rule 5 of BatchedExtraction: what a picture gives to each texel of a chart.

namespace foreview::oracle {

inline constexpr double kBatchedFootprint = 2;

/// Which polygon's plane a texel lies on.
struct TexelOwner {
  int polygon = -1;     ///< -1: none, nothing is ever taken
  bool inside = false;  ///< the texel's centre lies in the polygon; else in its gutter
};
/// Of a group's block. `front`, one per member of the group: those that show no front have no gutter.
[[nodiscard]] Image<TexelOwner> texel_owners(const PolygonModel& model, const ChartLayout& layout, std::size_t group,
                                             const std::vector<bool>& front);

/// All of a picture that rule 5 asks for.
struct GatherSource {
  const ColourImage* colour = nullptr;  ///< undistorted
  const Image<Cell>* cells = nullptr;
  CameraModel camera;
  double near_plane = 0.02;
};

/// A texel as the picture shows it.
struct GatheredTexel {
  bool in_picture = false;  ///< before the camera, with four pixels about it (about each sample)
  bool taken = false;
  glm::dvec3 colour{0};
  glm::dvec2 pixel{0};  ///< of its centre
  double w = 0;         ///< 1/z of its centre
  double reach = 0;     ///< how much 1/z changes from a pixel to the next: |a| + |b|
  double step = 0;      ///< pixels, the longer of a texel's two steps
};
/// `texel`: continuous coordinates in the page.
[[nodiscard]] GatheredTexel gather(const Chart& chart, const PictureSurface& surface, const glm::dvec2& texel,
                                   const GatherSource& source);

}  // namespace foreview::oracle
