#include "oracle/hole_filling.h"

#include <algorithm>
#include <cmath>

namespace foreview::oracle {
namespace {

const glm::dvec3 kMidGrey(128);

bool any_valid(const Texture& texture) {
  return std::any_of(texture.valid.values.begin(), texture.valid.values.end(), [](unsigned char v) { return v != 0; });
}

/// Mean colour of the valid texels with x in [left, right), y in [top, bottom); how many in `count`.
glm::dvec3 mean_of_valid(const Texture& texture, int left, int top, int right, int bottom, int* count) {
  glm::dvec3 sum(0);
  *count = 0;
  for (int y = std::max(top, 0); y < std::min(bottom, texture.height()); ++y) {
    for (int x = std::max(left, 0); x < std::min(right, texture.width()); ++x) {
      if (texture.valid.at(x, y) == 0) continue;
      sum += texture.colour.at(x, y);
      ++*count;
    }
  }
  return *count > 0 ? sum / static_cast<double>(*count) : glm::dvec3(0);
}

}  // namespace

Texture fuse(const Texture& before, const Texture& fresh) {
  Texture result = before;
  for (std::size_t i = 0; i < result.colour.values.size(); ++i) {
    if (fresh.valid.values[i] == 0) continue;
    result.colour.values[i] = fresh.colour.values[i];
    result.valid.values[i] = 1;
  }
  return result;
}

ColourImage leave_holes_grey(const Texture& texture) {
  ColourImage result = texture.colour;
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    if (texture.valid.values[i] == 0) result.values[i] = kMidGrey;
  }
  return result;
}

glm::dvec3 bilinear_clamped(const ColourImage& image, double s, double t) {
  const double left = std::floor(s - 0.5), top = std::floor(t - 0.5);
  const double fx = s - 0.5 - left, fy = t - 0.5 - top;
  const auto tap = [&](double x, double y) {
    return image.at(static_cast<int>(std::clamp(x, 0.0, image.width - 1.0)),
                    static_cast<int>(std::clamp(y, 0.0, image.height - 1.0)));
  };
  return tap(left, top) * (1 - fx) * (1 - fy) + tap(left + 1, top) * fx * (1 - fy) +
         tap(left, top + 1) * (1 - fx) * fy + tap(left + 1, top + 1) * fx * fy;
}

Texture pull(const Texture& fine) {
  const int step_x = fine.width() > 1 ? 2 : 1, step_y = fine.height() > 1 ? 2 : 1;
  Texture coarse((fine.width() + step_x - 1) / step_x, (fine.height() + step_y - 1) / step_y);
  for (int y = 0; y < coarse.height(); ++y) {
    for (int x = 0; x < coarse.width(); ++x) {
      int count = 0;
      coarse.colour.at(x, y) = mean_of_valid(fine, x * step_x, y * step_y, (x + 1) * step_x, (y + 1) * step_y, &count);
      coarse.valid.at(x, y) = count > 0 ? 1 : 0;
    }
  }
  return coarse;
}

ColourImage push(const ColourImage& coarse, const Texture& fine) {
  ColourImage result = fine.colour;
  for (int y = 0; y < fine.height(); ++y) {
    for (int x = 0; x < fine.width(); ++x) {
      if (fine.valid.at(x, y) != 0) continue;
      const double s = fine.width() > 1 ? (x + 0.5) / 2 : 0.5, t = fine.height() > 1 ? (y + 0.5) / 2 : 0.5;
      result.at(x, y) = bilinear_clamped(coarse, s, t);
    }
  }
  return result;
}

ColourImage fill_by_pyramid(const Texture& texture) {
  if (!any_valid(texture)) return leave_holes_grey(texture);
  std::vector<Texture> levels{texture};
  while (levels.back().width() > 1 || levels.back().height() > 1) levels.push_back(pull(levels.back()));
  ColourImage filled = levels.back().colour;
  for (std::size_t i = levels.size() - 1; i-- > 0;) filled = push(filled, levels[i]);
  return filled;
}

ColourImage leave_holes_open(const Texture& texture, const Flags& open) {
  ColourImage result = fill_by_pyramid(texture);
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    if (texture.valid.values[i] == 0 && open.values[i] != 0) result.values[i] = kMidGrey;
  }
  return result;
}

ColourImage fill_iteratively(const Texture& texture, int* passes) {
  if (passes != nullptr) *passes = 0;
  if (!any_valid(texture)) return leave_holes_grey(texture);
  Texture now = texture;
  for (bool changed = true; changed;) {
    changed = false;
    const Texture before = now;
    for (int y = 0; y < now.height(); ++y) {
      for (int x = 0; x < now.width(); ++x) {
        if (before.valid.at(x, y) != 0) continue;
        int near = 0, count = 0;
        (void)mean_of_valid(before, x - 1, y - 1, x + 2, y + 2, &near);
        if (near == 0) continue;
        now.colour.at(x, y) = mean_of_valid(before, x - 2, y - 2, x + 3, y + 3, &count);
        now.valid.at(x, y) = 1;
        changed = true;
      }
    }
    if (changed && passes != nullptr) ++*passes;
  }
  return now.colour;
}

}  // namespace foreview::oracle
