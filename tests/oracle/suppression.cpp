#include "oracle/suppression.h"

#include <algorithm>
#include <cmath>

namespace foreview::oracle {
namespace {

double at_or_outside(const AlphaImage& alpha, int x, int y) {
  return alpha.contains(x, y) ? alpha.at(x, y) : kOutside;
}

AlphaImage keep_where_not_zero(const AlphaImage& alpha, const AlphaImage& verdict) {
  AlphaImage result = alpha;
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    if (verdict.values[i] == 0) result.values[i] = 0;
  }
  return result;
}

}  // namespace

AlphaImage diamond_pass(const AlphaImage& alpha, double alpha_c) {
  AlphaImage result = alpha;
  for (int y = 0; y < alpha.height; ++y) {
    for (int x = 0; x < alpha.width; ++x) {
      const double sum = at_or_outside(alpha, x - 1, y) + at_or_outside(alpha, x + 1, y) +
                         at_or_outside(alpha, x, y - 1) + at_or_outside(alpha, x, y + 1);
      if (sum <= alpha_c) result.at(x, y) = 0;
    }
  }
  return result;
}

AlphaImage reduce(const AlphaImage& alpha) {
  AlphaImage result((alpha.width + 1) / 2, (alpha.height + 1) / 2);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const double mean = (at_or_outside(alpha, 2 * x, 2 * y) + at_or_outside(alpha, 2 * x + 1, 2 * y) +
                           at_or_outside(alpha, 2 * x, 2 * y + 1) + at_or_outside(alpha, 2 * x + 1, 2 * y + 1)) /
                          4;
      result.at(x, y) = mean <= 3.0 / 4 ? 0 : mean;
    }
  }
  return result;
}

AlphaImage enlarge(const AlphaImage& alpha, int width, int height) {
  AlphaImage result(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x + 0.5) / 2 - 0.5, v = (y + 0.5) / 2 - 0.5;
      const double left = std::floor(u), top = std::floor(v);
      double value = 0;
      for (int dy = 0; dy < 2; ++dy) {
        for (int dx = 0; dx < 2; ++dx) {
          const int tap_x = std::clamp(static_cast<int>(left) + dx, 0, alpha.width - 1);
          const int tap_y = std::clamp(static_cast<int>(top) + dy, 0, alpha.height - 1);
          value += alpha.at(tap_x, tap_y) * (dx == 0 ? 1 - (u - left) : u - left) * (dy == 0 ? 1 - (v - top) : v - top);
        }
      }
      result.at(x, y) = value <= 15.0 / 16 ? 0 : value;
    }
  }
  return result;
}

AlphaImage alternating_pass(const AlphaImage& alpha) {
  return keep_where_not_zero(alpha, enlarge(reduce(alpha), alpha.width, alpha.height));
}

AlphaImage progressive(const AlphaImage& alpha, int n) {
  std::vector<AlphaImage> sizes{alpha};
  for (int i = 0; i < n; ++i) sizes.push_back(reduce(sizes.back()));
  AlphaImage verdict = sizes.back();
  for (int i = n - 1; i >= 0; --i) {
    const AlphaImage& size = sizes[static_cast<std::size_t>(i)];
    verdict = enlarge(verdict, size.width, size.height);
  }
  return keep_where_not_zero(alpha, verdict);
}

}  // namespace foreview::oracle
