#include "foreview/viewer/draw_order.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace foreview {
namespace {

/// Near to far, eight buckets each time the distance (metres) doubles: what is behind the camera comes first.
std::uint8_t bucket_of(float distance) {
  if (!(distance > 1e-3F)) return 0;
  return static_cast<std::uint8_t>(std::clamp(8.0F * std::log2(distance * 1e3F), 0.0F, 255.0F));
}

}  // namespace

DrawOrder::DrawOrder(const ViewGeometry& geometry)
    : triangles_(geometry.triangles), part_centres_(geometry.part_centres) {
  const auto vertex = [&](std::size_t corner) -> const ViewGeometry::Vertex& {
    return geometry.vertices[triangles_[corner]];
  };
  for (std::size_t t = 0; t < triangles_.size(); t += 3) {
    const ViewGeometry::Vertex& corner = vertex(t);
    const bool same = t > 0 && vertex(t - 3).polygon == corner.polygon;
    if (!same) balls_.push_back({{}, 0, corner.part, static_cast<std::uint32_t>(t), 0});
    balls_.back().count += 3;
  }
  for (Ball& ball : balls_) {
    for (std::uint32_t i = 0; i < ball.count; ++i) ball.centre += vertex(ball.first + i).position;
    ball.centre /= static_cast<float>(ball.count);
    for (std::uint32_t i = 0; i < ball.count; ++i) {
      ball.radius = std::max(ball.radius, glm::distance(ball.centre, vertex(ball.first + i).position));
    }
  }
  sorted_.resize(triangles_.size());
  bucket_.resize(balls_.size());
  rows_.resize(part_centres_.size());
}

std::span<const std::uint32_t> DrawOrder::front_to_back(const Pose& world_from_camera,
                                                        std::span<const Pose> world_from_part) {
  assert(world_from_part.size() == rows_.size());
  const glm::dvec3 forward = world_from_camera.rotate({0, 0, 1});
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Pose& part = world_from_part[i];
    rows_[i].forward = glm::vec3(glm::conjugate(part.rotation) * forward);
    rows_[i].offset = static_cast<float>(glm::dot(forward, part * part_centres_[i] - world_from_camera.translation));
  }
  ends_.fill(0);
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const Ball& ball = balls_[i];
    const Row& row = rows_[ball.part];
    bucket_[i] = bucket_of(glm::dot(row.forward, ball.centre) + row.offset - ball.radius);
    ends_[bucket_[i]] += ball.count;
  }
  std::uint32_t begin = 0;
  for (std::uint32_t& end : ends_) begin += std::exchange(end, begin);
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const Ball& ball = balls_[i];
    std::copy_n(triangles_.begin() + ball.first, ball.count, sorted_.begin() + ends_[bucket_[i]]);
    ends_[bucket_[i]] += ball.count;
  }
  return sorted_;
}

}  // namespace foreview
