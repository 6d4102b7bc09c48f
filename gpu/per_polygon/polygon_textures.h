#pragma once
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::per_polygon {

/// The textures that the method of 2005 works in: one of w x h RGBA8 per polygon (rule 5 of PerPolygonExtraction),
/// created once (spec 10). Colour, and alpha 1 where observed.
class PolygonTextures {
 public:
  /// Needs a current context. Throws InputError if the options are out of range, if max_texels is beyond the driver's
  /// largest texture, or if all together would take more than kMaxBytes.
  PolygonTextures(const PolygonModel& model, const ChartOptions& options);
  static constexpr double kMaxBytes = 4.0 * (1u << 30);

  struct Item {
    GlTexture texture;
    int width = 0, height = 0;  ///< texels
    PolygonFrame frame;         ///< its box fills the texture
  };
  [[nodiscard]] const Item& operator[](std::size_t polygon) const { return items_[polygon]; }
  [[nodiscard]] std::size_t size() const { return items_.size(); }
  [[nodiscard]] int widest() const { return widest_; }
  [[nodiscard]] int highest() const { return highest_; }
  /// Nothing observed.
  void clear();

 private:
  std::vector<Item> items_;
  int widest_ = 1, highest_ = 1;
};

/// Texels along an axis of `extent` metres: min(max_texels, next power of two >= density * extent), spec 6.
[[nodiscard]] int texels_along(double extent, double density, int max_texels);

}  // namespace foreview::per_polygon
