#include "foreview/gpu/per_polygon/polygon_textures.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "foreview/scene/errors.h"

namespace foreview::per_polygon {

int texels_along(double extent, double density, int max_texels) {
  const double wanted = density * extent * (1 - 1e-6);
  int texels = 1;
  while (texels < wanted && texels < max_texels) texels *= 2;
  return std::min(texels, max_texels);
}

PolygonTextures::PolygonTextures(const PolygonModel& model, const ChartOptions& options) {
  if (!(options.texels_per_metre > 0) || !std::isfinite(options.texels_per_metre)) {
    throw InputError("--density", "must be a positive number of texels per metre");
  }
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (options.max_texels < 1 || options.max_texels > limit) {
    throw InputError("--max-texels", std::to_string(options.max_texels) +
                                         " is out of range; expected 1 to this graphics driver's limit, " +
                                         std::to_string(limit));
  }
  items_.resize(model.polygons().size());
  double bytes = 0;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    Item& item = items_[i];
    item.frame = polygon_frame(model, i);
    const double own_density = model.polygons()[i].texels_per_metre;
    const double density = own_density > 0 ? own_density : options.texels_per_metre;
    const int most = own_density > 0 ? limit : options.max_texels;
    item.width = texels_along(item.frame.extent.x, density, most);
    item.height = texels_along(item.frame.extent.y, density, most);
    widest_ = std::max(widest_, item.width);
    highest_ = std::max(highest_, item.height);
    bytes += 4.0 * item.width * item.height;
  }
  if (bytes > kMaxBytes) {
    throw InputError("--density, --max-texels",
                     "the polygons' textures would take " + std::to_string(static_cast<long>(bytes / (1 << 20))) +
                         " MB, expected at most " + std::to_string(static_cast<long>(kMaxBytes / (1 << 20))) + " MB");
  }
  for (Item& item : items_) item.texture = make_texture_2d(GL_RGBA8, item.width, item.height);
  clear();
}

void PolygonTextures::clear() {
  for (const Item& item : items_) glClearTexImage(item.texture.id(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
}

}  // namespace foreview::per_polygon
