#pragma once
#include "oracle/image.h"

namespace foreview::oracle {

/// Step 4 (spec 5) on plain alpha images. Beyond the image alpha is 31/32.

/// One diamond pass (eq. 5.5, corrected): a texel dies where its four edge neighbours sum to alpha_c or less.
[[nodiscard]] AlphaImage diamond_pass(const AlphaImage& alpha, double alpha_c);
/// To half the size, rounded up: the mean of 2x2 texels, 0 where that is <= 3/4 (eq. 5.1).
[[nodiscard]] AlphaImage reduce(const AlphaImage& alpha);
/// Bilinearly back to (width, height), twice the size or one less: 0 where <= 15/16 (eq. 5.2).
[[nodiscard]] AlphaImage enlarge(const AlphaImage& alpha, int width, int height);
/// One reduction and enlargement (5.1.2); survivors keep their alpha.
[[nodiscard]] AlphaImage alternating_pass(const AlphaImage& alpha);
/// n reductions, then n enlargements (5.1.3); survivors keep their alpha.
[[nodiscard]] AlphaImage progressive(const AlphaImage& alpha, int n);

}  // namespace foreview::oracle
