#include "oracle/polygon_extraction.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "oracle/suppression.h"

namespace foreview::oracle {

AlphaImage suppress(const AlphaImage& alpha, const Options& options) {
  AlphaImage result = alpha;
  switch (options.suppression) {
    case Suppression::none:
      break;
    case Suppression::diamond:
      for (int i = 0; i < options.passes; ++i) result = diamond_pass(result, options.alpha_c);
      break;
    case Suppression::alternating:
      for (int i = 0; i < options.passes; ++i) result = alternating_pass(result);
      break;
    case Suppression::progressive:
      result = progressive(result, options.passes);
      break;
  }
  return result;
}

Flags open_holes(const PolygonModel& model, std::size_t polygon, const Texture& texture) {
  const PolygonFrame frame = polygon_frame(model, polygon);
  const int width = texture.width(), height = texture.height();
  const std::size_t corners = model.polygons()[polygon].corner_count;
  const auto corner = [&](std::size_t i) {
    const glm::dvec2 plane = frame.plane_from_part(model.corner(polygon, i % corners));
    return glm::dvec2(plane.x / frame.extent.x * width, plane.y / frame.extent.y * height);
  };
  double area = 0;
  for (std::size_t i = 0; i < corners; ++i) {
    area += corner(i).x * corner(i + 1).y - corner(i).y * corner(i + 1).x;
  }
  // Texels that a point lies outside the line through an edge; negative inside.
  const auto outside = [&](const glm::dvec2& p, std::size_t i) {
    const glm::dvec2 along = corner(i + 1) - corner(i), to = p - corner(i);
    return (area > 0 ? -1 : 1) * (along.x * to.y - along.y * to.x) / glm::length(along);
  };
  const auto outwards = [&](std::size_t i) {
    const glm::dvec2 along = glm::normalize(corner(i + 1) - corner(i));
    return area > 0 ? glm::dvec2(along.y, -along.x) : glm::dvec2(-along.y, along.x);
  };
  Flags result(width, height, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::dvec2 centre(x + 0.5, y + 0.5);
      glm::dvec2 moved = centre;
      double farthest = 0;
      for (std::size_t i = 0; i < corners; ++i) {
        farthest = std::max(farthest, outside(centre, i));
        if (outside(moved, i) > -1) moved -= outwards(i) * (outside(moved, i) + 1);
      }
      const int u = static_cast<int>(std::clamp(std::floor(moved.x), 0.0, width - 1.0));
      const int v = static_cast<int>(std::clamp(std::floor(moved.y), 0.0, height - 1.0));
      result.at(x, y) = farthest <= 0.25 || (farthest <= 2 && texture.valid.at(u, v) == 0) ? 1 : 0;
    }
  }
  return result;
}

ColourImage fill(const Texture& texture, Filling filling, const Flags& open) {
  switch (filling) {
    case Filling::pyramid:
      return fill_by_pyramid(texture);
    case Filling::iterative:
      return fill_iteratively(texture);
    case Filling::none:
      break;
  }
  return leave_holes_open(texture, open);
}

PolygonExtraction::PolygonExtraction(const PolygonModel& model, const Options& options)
    : model_(model), options_(options), textures_(model.polygons().size()), newest_(model.polygons().size()) {}

PreparedFrame PolygonExtraction::prepare(const CameraFrame& frame) const {
  PreparedFrame result;
  result.frame = &frame;
  result.picture = undistort(frame.picture, frame.camera);
  result.visibility = visibility(model_, frame.camera.undistorted(), frame.state, options_.near_plane);
  return result;
}

PolygonResult PolygonExtraction::inspect(const PreparedFrame& prepared, std::size_t polygon) const {
  const CameraFrame& frame = *prepared.frame;
  PolygonResult result;
  result.projected = project(model_, polygon, frame.camera.undistorted(), frame.state, options_.near_plane);
  result.skip = skip_reason(result.projected);
  if (result.skip != Skip::none) return result;

  result.before = occlusion_mask(model_, polygon, result.projected, prepared.visibility, prepared.picture);
  const int shorter = std::min(result.projected.box.width(), result.projected.box.height());
  result.exempt_small = shorter < options_.small_texture;
  result.after = result.before;
  if (!result.exempt_small) {
    result.after.alpha = suppress(result.before.alpha, options_);
    result.after.low = suppress(result.before.low, options_);
    result.after.high = suppress(result.before.high, options_);
  }

  const PolygonFrame plane = polygon_frame(model_, polygon);
  const glm::ivec2 size =
      texture_size(model_.polygons()[polygon], plane.extent, options_.texels_per_metre, options_.max_texels);
  result.fresh = normalise(model_, polygon, plane, size, result.projected, result.after, prepared.picture, frame.state,
                           options_.near_plane);
  if (textures_[polygon].width() == 0) {
    result.fused = result.fresh.texture;
  } else {
    const bool late = newest_[polygon].has_value() && frame.state.stamp < *newest_[polygon];
    result.fused =
        late ? fuse(result.fresh.texture, textures_[polygon]) : fuse(textures_[polygon], result.fresh.texture);
  }
  result.filled = fill(result.fused, options_.fill, open_holes(model_, polygon, result.fused));
  return result;
}

std::size_t PolygonExtraction::extract(const PreparedFrame& prepared) {
  std::size_t touched = 0;
  const Timestamp stamp = prepared.frame->state.stamp;
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    PolygonResult result = inspect(prepared, i);
    if (result.skip != Skip::none) continue;
    textures_[i] = std::move(result.fused);
    if (!newest_[i].has_value() || *newest_[i] < stamp) newest_[i] = stamp;
    ++touched;
  }
  return touched;
}

ChartBlock copy_to_chart(const Chart& chart, const PolygonFrame& frame, const Texture& texture,
                         const ColourImage& filled) {
  const auto observed_at = [&](double s, double t) {
    return texture.valid.at(static_cast<int>(std::clamp(std::floor(s), 0.0, texture.width() - 1.0)),
                            static_cast<int>(std::clamp(std::floor(t), 0.0, texture.height() - 1.0)));
  };
  ChartBlock block;
  block.colour = ColourImage(chart.size.x, chart.size.y);
  block.observed = block.doubtful = Flags(chart.size.x, chart.size.y);
  for (int y = 0; y < chart.size.y; ++y) {
    for (int x = 0; x < chart.size.x; ++x) {
      const glm::dvec2 texel = glm::dvec2(chart.origin) + glm::dvec2(x + 0.5, y + 0.5);
      const glm::dvec2 plane = frame.plane_from_part(chart.part_from_texel(texel));
      const double s = plane.x / frame.extent.x * texture.width(), t = plane.y / frame.extent.y * texture.height();
      block.colour.at(x, y) = bilinear_clamped(filled, s, t);
      block.observed.at(x, y) = observed_at(s, t);
      for (const double ds : {-1e-3, 1e-3}) {
        for (const double dt : {-1e-3, 1e-3}) {
          if (observed_at(s + ds, t + dt) != block.observed.at(x, y)) block.doubtful.at(x, y) = 1;
        }
      }
    }
  }
  return block;
}

}  // namespace foreview::oracle
