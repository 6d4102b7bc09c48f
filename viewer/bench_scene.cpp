#include "foreview/viewer/bench_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <string>

namespace foreview {
namespace {

constexpr double kRadius = 3;                 // metres
constexpr double kUnevenness = 0.12;          // of the radius
constexpr std::int64_t kPeriod = 40'000'000;  // nanoseconds between pictures

/// A point of the wall, from its place on the cube -1..1.
glm::dvec3 wall_point(const glm::dvec3& on_cube) {
  const glm::dvec3 d = glm::normalize(on_cube);
  const double bumps = std::sin(5 * d.x + 1) * std::sin(6 * d.y) * std::cos(4 * d.z) +
                       0.3 * std::sin(17 * d.x) * std::sin(19 * d.z + 2 * d.y);
  return kRadius * (1 + kUnevenness * bumps) * d;
}

}  // namespace

PolygonModel bumpy_room(std::size_t polygons) {
  const int k = std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(polygons) / 12))));
  RawMesh mesh;
  // Corners by their place on the cube's grid, so that its sides share those along their edges.
  std::map<std::array<int, 3>, std::uint32_t> known;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = known.try_emplace(at, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) {
      mesh.vertices.push_back(wall_point({2.0 * at[0] / k - 1, 2.0 * at[1] / k - 1, 2.0 * at[2] / k - 1}));
    }
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int side : {0, k}) {
      for (int i = 0; i < k; ++i) {
        for (int j = 0; j < k; ++j) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> at{};
            at[axis] = side;
            at[u] = i + di;
            at[v] = j + dj;
            return vertex(at);
          };
          std::array<std::uint32_t, 4> quad{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          // u, v and the axis are right-handed: on the far side this order faces outwards.
          if (side == k) std::swap(quad[1], quad[3]);
          mesh.faces.push_back({quad[0], quad[1], quad[2]});
          mesh.faces.push_back({quad[0], quad[2], quad[3]});
        }
      }
    }
  }
  ImportOptions options;
  options.merge_coplanar = false;
  options.backdrop = false;
  return build_polygon_model(mesh, options, nullptr, "the benchmark's room");
}

CameraModel room_camera(double megapixels) {
  CameraModel camera;
  camera.name = "room";
  camera.height = std::max(2, 2 * static_cast<int>(std::lround(std::sqrt(megapixels * 1e6 * 3 / 4) / 2)));
  camera.width = 2 * static_cast<int>(std::lround(camera.height * 2.0 / 3));
  const double focal_length = camera.width / 2.0 / std::tan(std::numbers::pi / 6);
  camera.focal_length = {focal_length, focal_length};
  camera.principal_point = {camera.width / 2.0, camera.height / 2.0};
  return camera;
}

BenchPictures room_pictures(const CameraModel& camera, std::size_t count) {
  cv::Mat pattern(camera.height, camera.width, CV_8UC3);
  for (int y = 0; y < camera.height; ++y) {
    auto* row = pattern.ptr<cv::Vec3b>(y);
    for (int x = 0; x < camera.width; ++x) {
      row[x] = {static_cast<unsigned char>(x * 255 / camera.width), static_cast<unsigned char>((x ^ y) & 255),
                static_cast<unsigned char>(y * 255 / camera.height)};
    }
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back("room " + std::to_string(i));
  // All frames share the pattern's memory.
  return {std::move(names),
          [camera, pattern, count](std::size_t i) -> std::optional<CameraFrame> {
            const double turn = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
            const glm::dvec3 eye(0.3 * std::cos(2 * turn), 0.3 * std::sin(3 * turn), 0.1 * std::sin(turn));
            const glm::dvec3 ahead(std::cos(turn), std::sin(turn), 0.3 * std::sin(2 * turn));
            CameraFrame frame;
            frame.picture = pattern;
            frame.camera = camera;
            frame.state.stamp = Timestamp{static_cast<std::int64_t>(i + 1) * kPeriod};
            frame.state.world_from_camera = looking_at(eye, eye + ahead, {0, 0, 1});
            frame.state.world_from_part = {Pose{}};
            return frame;
          },
          1};
}

}  // namespace foreview
