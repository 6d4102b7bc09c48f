#include "foreview/viewer/texture_proposal.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "foreview/viewer/camera_surroundings.h"

namespace foreview {
namespace {

constexpr std::size_t kPictures = 16;   ///< per camera
constexpr int kColumns = 8, kRows = 6;  ///< rays per picture

/// A ball around a polygon, in its part's frame.
struct Ball {
  glm::dvec3 centre{0};
  double radius = 0;
};

std::vector<Ball> balls_around_polygons(const PolygonModel& model) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const auto corners = model.corners_of(i);
    Ball ball;
    for (const std::uint32_t corner : corners) ball.centre += model.vertices()[corner];
    ball.centre /= static_cast<double>(corners.size());
    for (const std::uint32_t corner : corners) {
      ball.radius = std::max(ball.radius, glm::distance(ball.centre, model.vertices()[corner]));
    }
    balls.push_back(ball);
  }
  return balls;
}

/// Casts rays from one place of a camera.
class RayCaster {
 public:
  RayCaster(const PolygonModel& model, const std::vector<Ball>& balls, const CaptureState& state)
      : model_(model), state_(state) {
    std::vector<Pose> camera_from_part;
    for (const Pose& pose : state.world_from_part) {
      part_from_world_.push_back(pose.inverse());
      camera_from_part.push_back(state.world_from_camera.inverse() * pose);
    }
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const Polygon& polygon = model.polygons()[i];
      if (polygon.is_backdrop) continue;
      const glm::dvec3 centre = camera_from_part[polygon.part] * balls[i].centre;
      // A little wider than it is, for what rounding may do.
      const double radius = balls[i].radius * (1 + 1e-9) + 1e-9;
      if (centre.z + radius <= 0) continue;
      Candidate candidate{static_cast<std::uint32_t>(i), glm::dvec2(-kInfinity), glm::dvec2(kInfinity)};
      if (centre.z - radius > 0) {
        const glm::dvec2 lower = glm::dvec2(centre) - radius, upper = glm::dvec2(centre) + radius;
        candidate.lower = glm::min(lower / (centre.z - radius), lower / (centre.z + radius));
        candidate.upper = glm::max(upper / (centre.z - radius), upper / (centre.z + radius));
      }
      candidates_.push_back(candidate);
    }
  }
  /// Distance along `ray` (in the camera's frame, its z is 1; in multiples of it, and so z) to the nearest polygon in
  /// front, or infinity.
  [[nodiscard]] double nearest(const glm::dvec3& ray) const {
    const glm::dvec3 direction = state_.world_from_camera.rotate(ray);
    std::vector<glm::dvec3> origins, directions;
    for (const Pose& pose : part_from_world_) {
      origins.push_back(pose * state_.world_from_camera.translation);
      directions.push_back(pose.rotate(direction));
    }
    double best = kInfinity;
    for (const Candidate& candidate : candidates_) {
      if (ray.x < candidate.lower.x || ray.y < candidate.lower.y || ray.x > candidate.upper.x ||
          ray.y > candidate.upper.y) {
        continue;
      }
      const Polygon& polygon = model_.polygons()[candidate.polygon];
      const glm::dvec3 &from = origins[polygon.part], &along = directions[polygon.part];
      const double distance = (polygon.offset - glm::dot(polygon.normal, from)) / glm::dot(polygon.normal, along);
      if (distance > 0 && distance < best && contains(candidate.polygon, from + distance * along)) best = distance;
    }
    return best;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  /// A polygon that a ray with x / z and y / z within these bounds may meet.
  struct Candidate {
    std::uint32_t polygon = 0;
    glm::dvec2 lower{0}, upper{0};
  };
  [[nodiscard]] bool contains(std::size_t polygon, const glm::dvec3& point) const {
    const std::size_t corners = model_.polygons()[polygon].corner_count;
    for (std::size_t i = 0; i < corners; ++i) {
      const glm::dvec3 &a = model_.corner(polygon, i), &b = model_.corner(polygon, (i + 1) % corners);
      if (glm::dot(glm::cross(b - a, point - a), model_.polygons()[polygon].normal) < 0) return false;
    }
    return true;
  }
  const PolygonModel& model_;
  const CaptureState& state_;
  std::vector<Pose> part_from_world_;
  std::vector<Candidate> candidates_;
};

std::vector<double> resolved_densities(const Recording& recording, const PolygonModel& model) {
  std::vector<double> densities;
  const std::vector<Ball> balls = balls_around_polygons(model);
  for (std::size_t c = 0; c < recording.cameras().size(); ++c) {
    const Recording::Camera& camera = recording.cameras()[c];
    const std::size_t count = std::min(kPictures, camera.pictures.size());
    const double focal_length = std::max(camera.model.focal_length.x, camera.model.focal_length.y);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t picture = i * camera.pictures.size() / count;
      const auto state = recording.capture_state(c, camera.pictures[picture].stamp, model);
      if (!state) continue;
      const RayCaster caster(model, balls, *state);
      for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
          const glm::dvec2 pixel((column + 0.5) * camera.model.width / kColumns,
                                 (row + 0.5) * camera.model.height / kRows);
          const double z = caster.nearest(camera.model.ray_from_pixel(pixel));
          if (std::isfinite(z)) densities.push_back(focal_length / z);
        }
      }
    }
  }
  return densities;
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
    const auto quartile = densities.begin() + static_cast<std::ptrdiff_t>(densities.size() * 3 / 4);
    std::nth_element(densities.begin(), quartile, densities.end());
    proposal.texels_per_metre = round_number(std::clamp(*quartile, 50.0, 2000.0));
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
