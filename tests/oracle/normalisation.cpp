#include "oracle/normalisation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview::oracle {
namespace {

int texels_along(double extent, double texels_per_metre, int max_texels) {
  int texels = 1;
  while (texels < max_texels && texels < texels_per_metre * extent * (1 - 1e-6)) texels *= 2;
  return std::min(texels, max_texels);
}

/// The upper left of the four pixels around a point of the picture.
glm::ivec2 first_tap(const glm::dvec2& pixel) {
  return {static_cast<int>(std::floor(pixel.x - 0.5)), static_cast<int>(std::floor(pixel.y - 0.5))};
}

bool all_taps_valid(const AlphaImage& alpha, const Box& box, const glm::dvec2& pixel) {
  const glm::ivec2 tap = first_tap(pixel);
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const int x = tap.x + dx - box.left, y = tap.y + dy - box.top;
      if (!alpha.contains(x, y) || !(alpha.at(x, y) > kOutside)) return false;
    }
  }
  return true;
}

glm::dvec3 bilinear(const ColourImage& picture, const glm::dvec2& pixel) {
  const glm::ivec2 tap = first_tap(pixel);
  const double fx = pixel.x - 0.5 - tap.x, fy = pixel.y - 0.5 - tap.y;
  return picture.at(tap.x, tap.y) * (1 - fx) * (1 - fy) + picture.at(tap.x + 1, tap.y) * fx * (1 - fy) +
         picture.at(tap.x, tap.y + 1) * (1 - fx) * fy + picture.at(tap.x + 1, tap.y + 1) * fx * fy;
}

/// A texel's sample with a given number of cells along each side.
struct Sample {
  bool valid = true, surely = true, possibly = true;
  glm::dvec3 colour{0};
};

/// The texels' plane in the camera's frame: the point at (s, t) texels is origin + s * s_step + t * t_step.
struct TexelPlane {
  glm::dvec3 origin{0}, s_step{0}, t_step{0};
  [[nodiscard]] glm::dvec3 point(double s, double t) const { return origin + s * s_step + t * t_step; }
};

Sample sample(const TexelPlane& plane, int i, int j, int n, const CameraModel& camera, const Mask& mask, const Box& box,
              const ColourImage& picture, double near_plane) {
  Sample result;
  for (int b = 0; b < n; ++b) {
    for (int a = 0; a < n; ++a) {
      const glm::dvec3 point = plane.point(i + (a + 0.5) / n, j + (b + 0.5) / n);
      if (!(point.z > near_plane * (1 + 1e-5))) result.surely = false;
      if (!(point.z > near_plane * (1 - 1e-5))) result.possibly = false;
      if (!(point.z > near_plane)) result.valid = false;
      if (!result.possibly) return result;
      const glm::dvec2 pixel = camera.pixel_from_camera(point);
      // Far outside the picture nothing is in doubt, and the pixel's number would not fit an int.
      if (!(pixel.x > -10 && pixel.y > -10 && pixel.x < camera.width + 10 && pixel.y < camera.height + 10)) {
        result.valid = result.surely = result.possibly = false;
        return result;
      }
      if (!all_taps_valid(mask.alpha, box, pixel)) result.valid = false;
      constexpr double rounding = 2e-3;  // pixels that single precision may move a projection by
      bool possibly = false;
      for (const double dx : {-rounding, rounding}) {
        for (const double dy : {-rounding, rounding}) {
          if (!all_taps_valid(mask.low, box, pixel + glm::dvec2(dx, dy))) result.surely = false;
          if (all_taps_valid(mask.high, box, pixel + glm::dvec2(dx, dy))) possibly = true;
        }
      }
      if (!possibly) result.possibly = false;
      if (result.valid) result.colour += bilinear(picture, pixel) / static_cast<double>(n * n);
    }
  }
  return result;
}

/// The longer of a texel's two steps in pixels, from the projection's derivative at its centre.
double longer_step(const TexelPlane& plane, int i, int j, const CameraModel& camera) {
  const glm::dvec3 p = plane.point(i + 0.5, j + 0.5);
  double longest = 0;
  for (const glm::dvec3& step : {plane.s_step, plane.t_step}) {
    const glm::dvec2 moved = camera.focal_length * (glm::dvec2(step) - glm::dvec2(p) * (step.z / p.z)) / p.z;
    longest = std::max(longest, glm::length(moved));
  }
  return longest;
}

}  // namespace

glm::ivec2 texture_size(const glm::dvec2& extent, double texels_per_metre, int max_texels) {
  return {texels_along(extent.x, texels_per_metre, max_texels), texels_along(extent.y, texels_per_metre, max_texels)};
}

glm::ivec2 texture_size(const Polygon& polygon, const glm::dvec2& extent, double texels_per_metre, int max_texels) {
  if (polygon.texels_per_metre > 0) {
    return texture_size(extent, polygon.texels_per_metre, std::numeric_limits<int>::max());
  }
  return texture_size(extent, texels_per_metre, max_texels);
}

NormalisedTexture normalise(const PolygonModel& model, std::size_t polygon, const PolygonFrame& frame,
                            const glm::ivec2& size, const ProjectedPolygon& projected, const Mask& mask,
                            const UndistortedPicture& picture, const CaptureState& state, double near_plane) {
  const Pose camera_from_part =
      state.world_from_camera.inverse() * state.world_from_part[model.polygons()[polygon].part];
  TexelPlane plane;
  plane.origin = camera_from_part * frame.origin;
  plane.s_step = camera_from_part.rotate(frame.x_axis * (frame.extent.x / size.x));
  plane.t_step = camera_from_part.rotate(frame.y_axis * (frame.extent.y / size.y));

  NormalisedTexture result;
  result.texture = Texture(size.x, size.y);
  result.surely_valid = result.possibly_valid = result.colour_doubtful = Flags(size.x, size.y);
  for (int j = 0; j < size.y; ++j) {
    for (int i = 0; i < size.x; ++i) {
      if (!(plane.point(i + 0.5, j + 0.5).z > near_plane * (1 - 1e-5))) continue;  // so is a cell, whatever n is
      const double step = longer_step(plane, i, j, projected.camera);
      const auto cells = [](double s) { return static_cast<int>(std::clamp(std::ceil(s - 1e-3), 1.0, 4.0)); };
      const auto at = [&](int n) {
        return sample(plane, i, j, n, projected.camera, mask, projected.grown_box, picture.colour, near_plane);
      };
      const int n = cells(step);
      const Sample taken = at(n);
      bool surely = taken.surely, possibly = taken.possibly;
      for (const int other : {cells(step - 5e-4), cells(step + 5e-4)}) {
        if (other == n) continue;
        const Sample alternative = at(other);
        surely = surely && alternative.surely;
        possibly = possibly || alternative.possibly;
        result.colour_doubtful.at(i, j) = 1;
      }
      result.texture.valid.at(i, j) = taken.valid ? 1 : 0;
      result.texture.colour.at(i, j) = taken.valid ? taken.colour : glm::dvec3(0);
      result.surely_valid.at(i, j) = surely ? 1 : 0;
      result.possibly_valid.at(i, j) = possibly ? 1 : 0;
    }
  }
  return result;
}

}  // namespace foreview::oracle
