#pragma once
#include <glm/vec2.hpp>

#include "oracle/occlusion.h"
#include "oracle/projection.h"
#include "oracle/undistortion.h"

namespace foreview::oracle {

/// Spec 6, eq. 4.28-4.29: texels along both axes of a polygon's box.
/// A polygon with a density of its own (the backdrop) is not bounded by `max_texels`.
[[nodiscard]] glm::ivec2 texture_size(const Polygon& polygon, const glm::dvec2& extent, double texels_per_metre,
                                      int max_texels);
[[nodiscard]] glm::ivec2 texture_size(const glm::dvec2& extent, double texels_per_metre, int max_texels);

/// Step 5's result, with what rounding could change.
struct NormalisedTexture {
  Texture texture;
  Flags surely_valid, possibly_valid;
  Flags colour_doubtful;  ///< rounding decides into how many cells the texel is cut
};

/// Step 5. `mask` is of projected.grown_box, after suppression.
[[nodiscard]] NormalisedTexture normalise(const PolygonModel& model, std::size_t polygon, const PolygonFrame& frame,
                                          const glm::ivec2& size, const ProjectedPolygon& projected, const Mask& mask,
                                          const UndistortedPicture& picture, const CaptureState& state,
                                          double near_plane);

}  // namespace foreview::oracle
