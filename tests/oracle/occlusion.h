#pragma once
#include "oracle/image.h"
#include "oracle/projection.h"
#include "oracle/undistortion.h"
#include "oracle/visibility.h"

namespace foreview::oracle {

/// Alpha of a box's pixels, and the least and greatest that rounding could make of each: equal where nothing is in
/// doubt. Every later step on alpha is monotone, so it can be run on all three.
struct Mask {
  AlphaImage alpha, low, high;
};

/// Step 3, on projected.grown_box.
[[nodiscard]] Mask occlusion_mask(const PolygonModel& model, std::size_t polygon, const ProjectedPolygon& projected,
                                  const Visibility& visibility, const UndistortedPicture& picture);

}  // namespace foreview::oracle
