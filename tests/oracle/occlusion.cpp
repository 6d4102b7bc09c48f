#include "oracle/occlusion.h"

#include <algorithm>

namespace foreview::oracle {
namespace {

constexpr double kBand = 2.5;                 // pixels
constexpr double kOwnDepthTolerance = 1e-4;   // relative
constexpr double kAtTheOutline = 1.0 / 64;    // pixels
constexpr double kPositionRounding = 2e-3;    // pixels that single precision may move a distance by
constexpr double kBandDepthTolerance = 0.02;  // relative

enum class Owner { itself, neighbour, other };

Owner owner_kind(const PolygonModel& model, std::size_t polygon, int owner) {
  if (owner < 0) return Owner::other;
  if (static_cast<std::size_t>(owner) == polygon) return Owner::itself;
  const auto neighbours = model.neighbours_of(polygon);
  const bool found =
      std::find(neighbours.begin(), neighbours.end(), static_cast<std::uint32_t>(owner)) != neighbours.end();
  return found ? Owner::neighbour : Owner::other;
}

double alpha_inside(double depth, double own, Owner owner, bool at_the_outline) {
  if (owner == Owner::itself || (owner == Owner::neighbour && at_the_outline)) return 1;
  return depth > own * (1 + kOwnDepthTolerance) ? 0 : 1;
}

double alpha_in_band(double depth, double at_edge, Owner owner) {
  if (owner != Owner::other) return 1;
  if (depth > at_edge * (1 + kBandDepthTolerance)) return 0;
  if (depth >= at_edge * (1 - kBandDepthTolerance)) return 1;
  return kOutside;
}

}  // namespace

Mask occlusion_mask(const PolygonModel& model, std::size_t polygon, const ProjectedPolygon& projected,
                    const Visibility& visibility, const UndistortedPicture& picture) {
  const Box& box = projected.grown_box;
  Mask mask;
  mask.alpha = AlphaImage(box.width(), box.height(), kOutside);
  mask.low = mask.high = mask.alpha;
  for (int y = box.top; y < box.bottom; ++y) {
    for (int x = box.left; x < box.right; ++x) {
      const glm::dvec2 centre{x + 0.5, y + 0.5};
      const double distance = projected.signed_distance(centre);
      const double own = projected.inverse_z(centre);
      const double at_edge = projected.inverse_z(projected.nearest_on_outline(centre));
      const Hit& nearest = visibility.nearest.at(x, y);
      const Owner owner = owner_kind(model, polygon, nearest.polygon);

      double alpha = kOutside;
      if (picture.usable.at(x, y) != 0) {
        if (distance >= 0) {
          alpha = alpha_inside(nearest.inverse_z, own, owner, distance <= kAtTheOutline);
        } else if (distance >= -kBand) {
          alpha = alpha_in_band(nearest.inverse_z, at_edge, owner);
        }
      }

      std::vector<double> possible{alpha};
      const bool perhaps_unusable = picture.usable.at(x, y) == 0 || picture.doubtful.at(x, y) != 0;
      const bool perhaps_usable = picture.usable.at(x, y) != 0 || picture.doubtful.at(x, y) != 0;
      if (perhaps_unusable || distance < -kBand + kPositionRounding) possible.push_back(kOutside);
      if (perhaps_usable) {
        for (const Hit& hit : visibility.candidates.at(x, y)) {
          const Owner perhaps = owner_kind(model, polygon, hit.polygon);
          if (distance >= -kPositionRounding) {
            for (const double rounding : {-5e-5, 5e-5}) {
              possible.push_back(alpha_inside(hit.inverse_z, own * (1 + rounding), perhaps,
                                              distance <= kAtTheOutline + kPositionRounding));
              possible.push_back(alpha_inside(hit.inverse_z, own * (1 + rounding), perhaps,
                                              distance <= kAtTheOutline - kPositionRounding));
            }
          }
          if (distance <= kPositionRounding && distance >= -kBand - kPositionRounding) {
            for (const double rounding : {-1e-3, 1e-3}) {
              possible.push_back(alpha_in_band(hit.inverse_z, at_edge * (1 + rounding), perhaps));
            }
          }
        }
      }
      mask.alpha.at(x - box.left, y - box.top) = alpha;
      mask.low.at(x - box.left, y - box.top) = *std::min_element(possible.begin(), possible.end());
      mask.high.at(x - box.left, y - box.top) = *std::max_element(possible.begin(), possible.end());
    }
  }
  return mask;
}

}  // namespace foreview::oracle
