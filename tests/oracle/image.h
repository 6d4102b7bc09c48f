#pragma once
#include <cassert>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace foreview::oracle {

/// A picture of plain values, row by row, (0, 0) upper left.
template <class T>
struct Image {
  int width = 0, height = 0;
  std::vector<T> values;

  Image() = default;
  Image(int w, int h, T fill = T())
      : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}
  [[nodiscard]] bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  [[nodiscard]] T& at(int x, int y) { return values[index(x, y)]; }
  [[nodiscard]] const T& at(int x, int y) const { return values[index(x, y)]; }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    assert(contains(x, y));
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

using AlphaImage = Image<double>;                ///< 1 valid, 0 invalid, 31/32 outside (spec 5)
using ColourImage = Image<glm::dvec3>;           ///< blue, green, red, 0..255
using Flags = Image<unsigned char>;              ///< 0 or 1
inline constexpr double kOutside = 31.0 / 32.0;  ///< alpha of what is neither seen nor occluded

/// A polygon's texture: colours count only where valid.
struct Texture {
  ColourImage colour;
  Flags valid;
  Texture() = default;
  Texture(int w, int h) : colour(w, h), valid(w, h) {}
  [[nodiscard]] int width() const { return colour.width; }
  [[nodiscard]] int height() const { return colour.height; }
};

}  // namespace foreview::oracle
