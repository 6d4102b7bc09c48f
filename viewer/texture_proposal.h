#pragma once
#include "foreview/recordings/recording.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// Sizes of textures that suit a recording, where neither the user nor the recording names them.
struct TextureProposal {
  double texels_per_metre = 500;
  int max_texels = 256;
};

/// What the pictures resolve: a surface at distance z along the optical axis, seen square on, has f / z pixels a metre.
/// Of the surface that rays of up to 16 pictures per camera, spread over the recording, meet (not the model's
/// backdrop), half, by area, is resolved no better than this density: texels are spent by area. Rounded to 1, 1.5, 2,
/// 3, 5 or 7 times a power of ten, within 50..2000. 500 (spec 6) where no ray meets anything. max_texels: a power of
/// two that the largest polygon needs at this density, within 256..1024.
[[nodiscard]] TextureProposal propose_textures(const Recording& recording, const PolygonModel& model);

/// Where no picture is known: as if a camera with a focal length of 600 pixels stood as far from everything as the ball
/// around the model is wide from its middle; rounded and bounded likewise.
[[nodiscard]] TextureProposal propose_textures(const PolygonModel& model);

/// The one of 1, 1.5, 2, 3, 5, 7 times a power of ten whose ratio to `value` (positive) is nearest to 1.
[[nodiscard]] double round_number(double value);

}  // namespace foreview
