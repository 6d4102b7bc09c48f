#pragma once
#include "oracle/image.h"

namespace foreview::oracle {

/// Step 6 (spec 7): `fresh` where it is valid, else `before`.
[[nodiscard]] Texture fuse(const Texture& before, const Texture& fresh);

/// Step 7 (spec 9). All return colours for every texel, those of valid texels unchanged; mid grey where nothing is
/// valid at all.
[[nodiscard]] ColourImage leave_holes_grey(const Texture& texture);
/// HoleFilling::none: grey only where invalid and `open`, elsewhere as the pyramid fills.
[[nodiscard]] ColourImage leave_holes_open(const Texture& texture, const Flags& open);
/// 5.2.2-5.2.4.
[[nodiscard]] ColourImage fill_by_pyramid(const Texture& texture);
/// 5.2.5; `passes` counts those that changed something.
[[nodiscard]] ColourImage fill_iteratively(const Texture& texture, int* passes = nullptr);

/// One level up (eq. 5.6-5.9): each axis that is not 1 already is halved.
[[nodiscard]] Texture pull(const Texture& fine);
/// One level down: `coarse` enlarged bilinearly to `fine`'s size, `fine`'s valid texels written over it.
[[nodiscard]] ColourImage push(const ColourImage& coarse, const Texture& fine);
/// Bilinear, clamped to the image; (0.5, 0.5) is the centre of texel (0, 0).
[[nodiscard]] glm::dvec3 bilinear_clamped(const ColourImage& image, double s, double t);

}  // namespace foreview::oracle
