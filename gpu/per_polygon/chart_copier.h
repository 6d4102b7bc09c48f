#pragma once
#include <cstddef>
#include <cstdint>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/per_polygon/picture_data.h"
#include "foreview/gpu/per_polygon/polygon_textures.h"
#include "foreview/gpu/texture_store.h"

namespace foreview::per_polygon {

/// Rule 8 of PerPolygonExtraction: between a polygon's texture, which is stretched to powers of two, and its chart.
class ChartCopier {
 public:
  ChartCopier();
  /// Writes level 0 of the chart of the polygon at `slot`. `picture` must be bound.
  void copy(const PictureData& picture, std::size_t slot, GLuint filled, GLuint fused, const TextureStore& store);
  /// The way back: what is observed in the chart, into the polygon's texture.
  void adopt(const TextureStore& store, std::uint32_t polygon, const PolygonTextures::Item& texture);

 private:
  GlProgram copy_, adopt_;
};

}  // namespace foreview::per_polygon
