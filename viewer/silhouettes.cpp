#include "foreview/viewer/silhouettes.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <queue>

namespace foreview {
namespace {

constexpr double kSameSurface = 0.01;  ///< relative difference of 1/z at which two points count as one

/// One pair of neighbouring pixels between which a contour runs.
struct Contour {
  glm::dvec2 place;  ///< midway, pixels
  double occluder;   ///< its 1/z there
  int outside_x, outside_y;
};

class ContourFinder {
 public:
  ContourFinder(const SurfaceMap& surface, const std::vector<glm::dvec3>& planes)
      : surface_(surface),
        planes_(planes),
        wall_right_(surface.polygon.size(), CV_8U, cv::Scalar::all(0)),
        wall_below_(surface.polygon.size(), CV_8U, cv::Scalar::all(0)) {
    for (int y = 0; y < surface.polygon.rows; ++y) {
      for (int x = 0; x < surface.polygon.cols; ++x) {
        if (x + 1 < surface.polygon.cols) wall_right_.at<std::uint8_t>(y, x) = judge(x, y, x + 1, y) ? 1 : 0;
        if (y + 1 < surface.polygon.rows) wall_below_.at<std::uint8_t>(y, x) = judge(x, y, x, y + 1) ? 1 : 0;
      }
    }
  }
  [[nodiscard]] const std::vector<Contour>& contours() const { return contours_; }
  /// Whether a contour runs between two pixels side by side.
  [[nodiscard]] bool wall(int x0, int y0, int x1, int y1) const {
    const int x = std::min(x0, x1), y = std::min(y0, y1);
    return (y0 == y1 ? wall_right_ : wall_below_).at<std::uint8_t>(y, x) != 0;
  }

 private:
  [[nodiscard]] double plane(int polygon, const glm::dvec2& pixel) const {
    return polygon < 0 ? 0.0 : glm::dot(planes_[static_cast<std::size_t>(polygon)], glm::dvec3(pixel, 1.0));
  }
  bool judge(int x0, int y0, int x1, int y1) {
    const int a = surface_.polygon.at<int>(y0, x0), b = surface_.polygon.at<int>(y1, x1);
    if (a == b) return false;
    const glm::dvec2 centre_a(x0 + 0.5, y0 + 0.5), centre_b(x1 + 0.5, y1 + 0.5), midway = 0.5 * (centre_a + centre_b);
    const double at_a = plane(a, midway), at_b = plane(b, midway), gap = at_a - at_b;
    if (!(std::abs(gap) > kSilhouetteTolerance * std::max(at_a, at_b))) return false;
    // Planes that cross between the two centres meet there: a ridge or crease, however steep.
    if (gap * (plane(a, centre_a) - plane(b, centre_a)) <= 0) return false;
    if (gap * (plane(a, centre_b) - plane(b, centre_b)) <= 0) return false;
    contours_.push_back(gap > 0 ? Contour{midway, at_a, x1, y1} : Contour{midway, at_b, x0, y0});
    return true;
  }

  const SurfaceMap& surface_;
  const std::vector<glm::dvec3>& planes_;
  cv::Mat wall_right_, wall_below_;
  std::vector<Contour> contours_;
};

struct Reached {
  double distance_squared;
  std::size_t contour;
  int x, y;
  bool operator<(const Reached& other) const {  // the queue gives its greatest first: that must be the nearest
    if (distance_squared != other.distance_squared) return distance_squared > other.distance_squared;
    return contour > other.contour;
  }
};

}  // namespace

std::vector<glm::dvec3> inverse_depth_planes(const PolygonModel& model, const CameraModel& camera,
                                             const Pose& world_from_camera, const std::vector<Pose>& world_from_part) {
  assert(world_from_part.size() == model.parts().size());
  std::vector<glm::dvec3> planes;
  planes.reserve(model.polygons().size());
  const Pose camera_from_world = world_from_camera.inverse();
  for (const Polygon& polygon : model.polygons()) {
    const Pose camera_from_part = camera_from_world * world_from_part[polygon.part];
    const glm::dvec3 normal = camera_from_part.rotate(polygon.normal);
    const double offset = polygon.offset + glm::dot(normal, camera_from_part.translation);
    if (std::abs(offset) < 1e-12) {
      planes.emplace_back(0.0);
      continue;
    }
    // On the plane, normal . (ray z) = offset with the ray through the pixel, so 1/z = normal . ray / offset.
    const double u = normal.x / camera.focal_length.x, v = normal.y / camera.focal_length.y;
    planes.push_back(glm::dvec3(u, v, normal.z - u * camera.principal_point.x - v * camera.principal_point.y) / offset);
  }
  return planes;
}

cv::Mat beyond_contours(const SurfaceMap& surface, const std::vector<glm::dvec3>& planes, double reach) {
  assert(surface.polygon.type() == CV_32S && surface.inverse_z.type() == CV_32F);
  const ContourFinder finder(surface, planes);
  const std::vector<Contour>& contours = finder.contours();
  cv::Mat beyond(surface.polygon.size(), CV_8U, cv::Scalar::all(0));
  std::priority_queue<Reached> queue;
  const auto reach_out = [&](std::size_t contour, int x, int y) {
    if (beyond.at<std::uint8_t>(y, x) != 0) return;
    const glm::dvec2 way = glm::dvec2(x + 0.5, y + 0.5) - contours[contour].place;
    const double distance_squared = glm::dot(way, way);
    // Round the end of a contour the surface comes forward again: no longer behind this occluder.
    const double own = surface.inverse_z.at<float>(y, x);
    if (distance_squared > reach * reach || !(own < contours[contour].occluder)) return;
    queue.push({distance_squared, contour, x, y});
  };
  for (std::size_t i = 0; i < contours.size(); ++i) reach_out(i, contours[i].outside_x, contours[i].outside_y);
  while (!queue.empty()) {
    const Reached at = queue.top();
    queue.pop();
    std::uint8_t& here = beyond.at<std::uint8_t>(at.y, at.x);
    if (here != 0) continue;
    here = 255;
    constexpr int steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& step : steps) {
      const int x = at.x + step[0], y = at.y + step[1];
      if (x < 0 || y < 0 || x >= beyond.cols || y >= beyond.rows || finder.wall(at.x, at.y, x, y)) continue;
      reach_out(at.contour, x, y);
    }
  }
  return beyond;
}

cv::Mat pixels_beyond_silhouettes(const PolygonModel& model, const CameraModel& camera, const PredictedState& state,
                                  const SurfaceMap& predicted, const CameraModel& used_camera,
                                  const CaptureState& used_state, const SurfaceMap& used) {
  assert(predicted.polygon.cols == camera.width && predicted.polygon.rows == camera.height);
  assert(used.polygon.cols == used_camera.width && used.polygon.rows == used_camera.height);
  const std::vector<glm::dvec3> planes =
      inverse_depth_planes(model, used_camera, used_state.world_from_camera, used_state.world_from_part);
  const cv::Mat beyond = beyond_contours(used, planes);
  // By way of the part: what moved since the picture was taken is looked up where it was then.
  std::vector<Pose> used_camera_from_camera;
  for (std::size_t part = 0; part < model.parts().size(); ++part) {
    used_camera_from_camera.push_back(used_state.world_from_camera.inverse() * used_state.world_from_part[part] *
                                      state.world_from_part[part].inverse() * state.world_from_camera);
  }
  cv::Mat result(predicted.polygon.size(), CV_8U, cv::Scalar::all(0));
  for (int y = 0; y < result.rows; ++y) {
    for (int x = 0; x < result.cols; ++x) {
      const int polygon = predicted.polygon.at<int>(y, x);
      const double inverse_z = predicted.inverse_z.at<float>(y, x);
      if (polygon < 0 || !(inverse_z > 0)) continue;
      const std::size_t part = model.polygons()[static_cast<std::size_t>(polygon)].part;
      const glm::dvec3 point = used_camera_from_camera[part] * (camera.ray_from_pixel({x + 0.5, y + 0.5}) / inverse_z);
      if (!(point.z > 0)) continue;
      const glm::dvec2 pixel = used_camera.pixel_from_camera(point);
      if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < used_camera.width && pixel.y < used_camera.height)) continue;
      const int u = static_cast<int>(pixel.x), v = static_cast<int>(pixel.y);
      if (beyond.at<std::uint8_t>(v, u) == 0) continue;
      const double there = used.inverse_z.at<float>(v, u);
      const double own = glm::dot(planes[static_cast<std::size_t>(polygon)], glm::dvec3(u + 0.5, v + 0.5, 1.0));
      const bool visible =
          used.polygon.at<int>(v, u) == polygon || std::abs(own - there) <= kSameSurface * std::max(own, there);
      if (visible) result.at<std::uint8_t>(y, x) = 255;
    }
  }
  return result;
}

}  // namespace foreview
