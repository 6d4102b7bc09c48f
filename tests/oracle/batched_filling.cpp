#include "oracle/batched_filling.h"

#include <algorithm>
#include <cmath>

#include "oracle/hole_filling.h"

namespace foreview::oracle {

ShareLevel level_of(const Texture& base) {
  ShareLevel result(base.width(), base.height());
  for (std::size_t i = 0; i < base.valid.values.size(); ++i) {
    if (base.valid.values[i] == 0) continue;
    result.colour.values[i] = base.colour.values[i];
    result.share.values[i] = 1;
  }
  return result;
}

ShareLevel pull_by_share(const ShareLevel& finer) {
  ShareLevel result((finer.width() + 1) / 2, (finer.height() + 1) / 2);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      glm::dvec3 sum(0);
      double observed = 0;
      int children = 0;  // those of the chart
      for (const int i : {0, 1, 2, 3}) {
        const int cx = 2 * x + i % 2, cy = 2 * y + i / 2;
        if (!finer.colour.contains(cx, cy)) continue;
        ++children;
        observed += finer.share.at(cx, cy);
        sum += finer.share.at(cx, cy) * finer.colour.at(cx, cy);
      }
      if (observed == 0) continue;
      result.colour.at(x, y) = sum / observed;
      result.share.at(x, y) = std::max(observed / children, 1.0 / 255);
    }
  }
  return result;
}

std::vector<ShareLevel> levels_from(const ShareLevel& first) {
  std::vector<ShareLevel> result{first};
  while (result.back().width() > 1 || result.back().height() > 1) result.push_back(pull_by_share(result.back()));
  return result;
}

ColourImage enlarge(const ColourImage& coarser, int w, int h) {
  ColourImage result(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) result.at(x, y) = bilinear_clamped(coarser, (x + 0.5) / 2, (y + 0.5) / 2);
  }
  return result;
}

ColourImage push_by_share(const ShareLevel& level, const ColourImage& coarser) {
  ColourImage result = enlarge(coarser, level.width(), level.height());
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    const double own = std::min(1.0, 2 * level.share.values[i]);
    result.values[i] = own * level.colour.values[i] + (1 - own) * result.values[i];
  }
  return result;
}

ColourImage renewed(const FourthLevel& before, const FourthLevel& fresh) {
  ColourImage result = fresh.colour;
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    const glm::dvec3 d = fresh.colour.values[i] - before.colour.values[i];
    const bool is_near = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) <= 1.5;
    if (is_near && fresh.share.values[i] == before.share.values[i]) result.values[i] = before.colour.values[i];
  }
  return result;
}

std::vector<ColourImage> shown_levels(const std::vector<ShareLevel>& levels, std::size_t fourth,
                                      const FourthLevel* before) {
  std::vector<ColourImage> result(levels.size());
  for (std::size_t k = levels.size(); k-- > 0;) {
    result[k] = k + 1 == levels.size() ? levels[k].colour : push_by_share(levels[k], result[k + 1]);
    if (k == fourth && before != nullptr) result[k] = renewed(*before, {result[k], levels[k].share});
  }
  return result;
}

}  // namespace foreview::oracle
