#include "foreview/viewer/texture_proposal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "foreview/scene/ray_caster.h"
#include "foreview/viewer/camera_surroundings.h"

namespace foreview {
namespace {

constexpr std::size_t kPictures = 16;   ///< per camera
constexpr int kColumns = 8, kRows = 6;  ///< rays per picture

std::vector<double> resolved_densities(const Recording& recording, const PolygonModel& model) {
  std::vector<double> densities;
  const RayCaster caster(model);
  for (std::size_t c = 0; c < recording.cameras().size(); ++c) {
    const Recording::Camera& camera = recording.cameras()[c];
    const std::size_t count = std::min(kPictures, camera.pictures.size());
    const double focal_length = std::max(camera.model.focal_length.x, camera.model.focal_length.y);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t picture = i * camera.pictures.size() / count;
      const auto state = recording.capture_state(c, camera.pictures[picture].stamp, model);
      if (!state) continue;
      for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
          const glm::dvec2 pixel((column + 0.5) * camera.model.width / kColumns,
                                 (row + 0.5) * camera.model.height / kRows);
          const glm::dvec3 direction = state->world_from_camera.rotate(camera.model.ray_from_pixel(pixel));
          const auto hit = caster.nearest(state->world_from_camera.translation, direction, state->world_from_part,
                                          std::numeric_limits<double>::infinity());
          if (hit) densities.push_back(focal_length / hit->distance);
        }
      }
    }
  }
  return densities;
}

/// What half of the surface that the rays stand for is resolved no better than: texels are spent by area, and a ray at
/// twice the distance, with half the density, stands for four times the area.
double median_by_area(std::vector<double> densities) {
  std::sort(densities.begin(), densities.end());
  double area = 0;
  for (const double density : densities) area += 1 / (density * density);
  double below = 0;
  for (const double density : densities) {
    below += 1 / (density * density);
    if (2 * below >= area) return density;
  }
  return densities.back();
}

/// A power of two that the largest polygon needs, within 256..1024.
int max_texels_for(const PolygonModel& model, double texels_per_metre) {
  double largest = 0;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    if (model.polygons()[i].is_backdrop) continue;
    const glm::dvec2 extent = polygon_frame(model, i).extent;
    largest = std::max({largest, extent.x, extent.y});
  }
  int texels = 256;
  while (texels < 1024 && texels < largest * texels_per_metre) texels *= 2;
  return texels;
}

}  // namespace

double round_number(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  double best = power;
  for (const double digit : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0}) {
    if (std::abs(std::log(digit * power / value)) < std::abs(std::log(best / value))) best = digit * power;
  }
  return best;
}

TextureProposal propose_textures(const Recording& recording, const PolygonModel& model) {
  TextureProposal proposal;
  std::vector<double> densities = resolved_densities(recording, model);
  if (!densities.empty()) {
    proposal.texels_per_metre = round_number(std::clamp(median_by_area(std::move(densities)), 50.0, 2000.0));
  }
  proposal.max_texels = max_texels_for(model, proposal.texels_per_metre);
  return proposal;
}

TextureProposal propose_textures(const PolygonModel& model) {
  constexpr double kFocalLength = 600;
  const CameraSurroundings surroundings = find_surroundings(model, std::vector<Pose>(model.parts().size()), {});
  TextureProposal proposal;
  proposal.texels_per_metre = round_number(std::clamp(kFocalLength / surroundings.radius, 50.0, 2000.0));
  proposal.max_texels = max_texels_for(model, proposal.texels_per_metre);
  return proposal;
}

}  // namespace foreview
