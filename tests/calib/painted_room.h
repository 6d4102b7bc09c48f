#pragma once
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <opencv2/core.hpp>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::test {

/// A room of 4 by 3 by 5 m, seen from inside, painted with patches of grey: what its pictures show is known exactly.
struct PaintedRoom {
  glm::dvec3 half{2, 1.5, 2.5};

  [[nodiscard]] PolygonModel model() const { return build_polygon_model(mesh(), {.max_merged_extent = 10}); }
  [[nodiscard]] RawMesh mesh() const {
    RawMesh result;
    for (int corner = 0; corner < 8; ++corner) {
      result.vertices.push_back(half * glm::dvec3((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1));
    }
    result.faces = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    return result;
  }
  /// Where a line of sight from inside meets a wall.
  [[nodiscard]] glm::dvec3 wall_at(const glm::dvec3& origin, const glm::dvec3& direction) const {
    double nearest = 1e9;
    for (int i = 0; i < 3; ++i) {
      if (direction[i] != 0)
        nearest = std::min(nearest, ((direction[i] > 0 ? half[i] : -half[i]) - origin[i]) / direction[i]);
    }
    return origin + nearest * direction;
  }
  /// 0..255, in patches of some 10 cm whose edges are soft over 1 cm.
  [[nodiscard]] static double paint(const glm::dvec3& point) {
    const glm::dvec3 at = point / 0.1, cell = glm::floor(at), within = at - cell;
    double grey = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      glm::dvec3 lattice = cell;
      for (int i = 0; i < 3; ++i) {
        const bool upper = (corner >> i & 1) != 0;
        const double soft = glm::clamp((within[i] - 0.45) / 0.1, 0.0, 1.0);
        weight *= upper ? soft : 1 - soft;
        lattice[i] += upper ? 1 : 0;
      }
      std::uint32_t hash = 2166136261U;
      for (int i = 0; i < 3; ++i)
        hash = (hash ^ static_cast<std::uint32_t>(static_cast<int>(lattice[i]) + 1000)) * 16777619U;
      hash ^= hash >> 15;
      hash *= 2246822519U;
      grey += weight * static_cast<double>(hash >> 16 & 255U);
    }
    return grey;
  }
  [[nodiscard]] cv::Mat picture(const CameraModel& camera, const Pose& world_from_camera) const {
    cv::Mat result(camera.height, camera.width, CV_8UC3);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        double sum = 0;
        for (int sample = 0; sample < 4; ++sample) {
          const glm::dvec2 pixel(x + 0.25 + 0.5 * (sample & 1), y + 0.25 + 0.5 * (sample >> 1));
          const glm::dvec3 direction = world_from_camera.rotate(camera.ray_from_pixel(pixel));
          sum += paint(wall_at(world_from_camera.translation, direction));
        }
        const auto grey = static_cast<std::uint8_t>(std::lround(sum / 4));
        result.at<cv::Vec3b>(y, x) = {grey, grey, grey};
      }
    }
    return result;
  }
};

}  // namespace foreview::test
