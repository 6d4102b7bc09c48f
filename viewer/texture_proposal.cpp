#include "foreview/viewer/texture_proposal.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview {
namespace {

constexpr std::size_t kPictures = 16;   ///< per camera
constexpr int kColumns = 8, kRows = 6;  ///< rays per picture

/// Distance along `direction` (in multiples of it) to the nearest polygon in front, or infinity.
class RayCaster {
 public:
  RayCaster(const PolygonModel& model, const std::vector<Pose>& world_from_part) : model_(model) {
    for (const Pose& pose : world_from_part) part_from_world_.push_back(pose.inverse());
  }
  [[nodiscard]] double nearest(const glm::dvec3& origin, const glm::dvec3& direction) const {
    std::vector<glm::dvec3> origins, directions;
    for (const Pose& pose : part_from_world_) {
      origins.push_back(pose * origin);
      directions.push_back(pose.rotate(direction));
    }
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < model_.polygons().size(); ++i) {
      const Polygon& polygon = model_.polygons()[i];
      if (polygon.is_backdrop) continue;
      const glm::dvec3 &from = origins[polygon.part], &along = directions[polygon.part];
      const double distance = (polygon.offset - glm::dot(polygon.normal, from)) / glm::dot(polygon.normal, along);
      if (distance > 0 && distance < best && contains(i, from + distance * along)) best = distance;
    }
    return best;
  }

 private:
  [[nodiscard]] bool contains(std::size_t polygon, const glm::dvec3& point) const {
    const std::size_t corners = model_.polygons()[polygon].corner_count;
    for (std::size_t i = 0; i < corners; ++i) {
      const glm::dvec3 &a = model_.corner(polygon, i), &b = model_.corner(polygon, (i + 1) % corners);
      if (glm::dot(glm::cross(b - a, point - a), model_.polygons()[polygon].normal) < 0) return false;
    }
    return true;
  }
  const PolygonModel& model_;
  std::vector<Pose> part_from_world_;
};

std::vector<double> resolved_densities(const Recording& recording, const PolygonModel& model) {
  std::vector<double> densities;
  for (std::size_t c = 0; c < recording.cameras().size(); ++c) {
    const Recording::Camera& camera = recording.cameras()[c];
    const std::size_t count = std::min(kPictures, camera.pictures.size());
    const double focal_length = std::max(camera.model.focal_length.x, camera.model.focal_length.y);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t picture = i * camera.pictures.size() / count;
      const auto state = recording.capture_state(c, camera.pictures[picture].stamp, model);
      if (!state) continue;
      const RayCaster caster(model, state->world_from_part);
      for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
          const glm::dvec2 pixel((column + 0.5) * camera.model.width / kColumns,
                                 (row + 0.5) * camera.model.height / kRows);
          // The ray's z is 1, so that multiples of it are z.
          const double z = caster.nearest(state->world_from_camera.translation,
                                          state->world_from_camera.rotate(camera.model.ray_from_pixel(pixel)));
          if (std::isfinite(z)) densities.push_back(focal_length / z);
        }
      }
    }
  }
  return densities;
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
    const auto quartile = densities.begin() + static_cast<std::ptrdiff_t>(densities.size() * 3 / 4);
    std::nth_element(densities.begin(), quartile, densities.end());
    proposal.texels_per_metre = round_number(std::clamp(*quartile, 50.0, 2000.0));
  }
  double largest = 0;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    if (model.polygons()[i].is_backdrop) continue;
    const glm::dvec2 extent = polygon_frame(model, i).extent;
    largest = std::max({largest, extent.x, extent.y});
  }
  while (proposal.max_texels < 1024 && proposal.max_texels < largest * proposal.texels_per_metre) {
    proposal.max_texels *= 2;
  }
  return proposal;
}

}  // namespace foreview
