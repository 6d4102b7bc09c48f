#pragma once
#include <vector>

#include "oracle/image.h"

// Rules 6 and 7 of BatchedExtraction, of one chart.

namespace foreview::oracle {

/// A level of a chart: the colours of what was observed below each texel, and which share of it was.
struct ShareLevel {
  ColourImage colour;
  AlphaImage share;
  ShareLevel() = default;
  ShareLevel(int w, int h) : colour(w, h, glm::dvec3(0)), share(w, h, 0.0) {}
  [[nodiscard]] int width() const { return colour.width; }
  [[nodiscard]] int height() const { return colour.height; }
};
[[nodiscard]] ShareLevel level_of(const Texture& base);
/// Rule 6, one level up.
[[nodiscard]] ShareLevel pull_by_share(const ShareLevel& finer);
/// `first` and all levels above it, up to a single texel.
[[nodiscard]] std::vector<ShareLevel> levels_from(const ShareLevel& first);

/// `coarser` enlarged bilinearly to twice its size, cut to w x h; kept within its own texels.
[[nodiscard]] ColourImage enlarge(const ColourImage& coarser, int w, int h);
/// Rule 7, one level down. A level 0 has shares of 0 and 1 only, and so keeps what is observed.
[[nodiscard]] ColourImage push_by_share(const ShareLevel& level, const ColourImage& coarser);
/// Rule 7 at level 4.
struct FourthLevel {
  ColourImage colour;  ///< as it is shown
  AlphaImage share;    ///< of the texels below that are observed
};
/// What changed by no more than 1.5/255 in each channel stays as it was, if as much is observed as was.
[[nodiscard]] ColourImage renewed(const FourthLevel& before, const FourthLevel& fresh);
/// Rule 7: the colours of each of the levels, the last being the tip. `fourth` is the index of level 4, and `before`
/// what it was so far; null: there are none that could stay.
[[nodiscard]] std::vector<ColourImage> shown_levels(const std::vector<ShareLevel>& levels, std::size_t fourth,
                                                    const FourthLevel* before);

}  // namespace foreview::oracle
