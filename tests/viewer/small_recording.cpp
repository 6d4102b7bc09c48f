#include "viewer/small_recording.h"

#include <array>
#include <cmath>
#include <opencv2/core.hpp>

namespace foreview::test {
namespace {

cv::Vec3d wall_colour(double x, double y) {
  return {120 + 90 * std::sin(7 * x), 120 + 90 * std::sin(6 * y + 1), 120 + 60 * std::sin(5 * (x + y))};
}

cv::Vec3d board_colour(double x, double y) {
  return {40 + 30 * std::sin(20 * x), 220 - 30 * std::sin(25 * y), 200 + 40 * std::sin(17 * (x - y))};
}

/// What one ray meets: board, wall, or nothing (black).
cv::Vec3d colour_along(const glm::dvec3& origin, const glm::dvec3& direction, const Pose& board_from_world) {
  const glm::dvec3 from = board_from_world * origin, along = board_from_world.rotate(direction);
  const glm::dvec3 on_board = from + along * (-from.z / along.z);
  if (std::abs(on_board.x) <= 0.2 && std::abs(on_board.y) <= 0.2) return board_colour(on_board.x, on_board.y);
  const glm::dvec3 on_wall = origin + direction * ((2 - origin.z) / direction.z);
  if (std::abs(on_wall.x) <= 1.5 && std::abs(on_wall.y) <= 1.5) return wall_colour(on_wall.x, on_wall.y);
  return {0, 0, 0};
}

}  // namespace

SmallSite::SmallSite() {
  camera.width = 96;
  camera.height = 72;
  camera.focal_length = {90, 90};
  camera.principal_point = {48, 36};
}

Timestamp SmallSite::stamp(std::size_t instant) {
  return Timestamp::from_seconds(100) + Duration{static_cast<std::int64_t>(instant) * 100'000'000};
}

Pose SmallSite::world_from_camera(std::size_t camera, Timestamp stamp) {
  const double t = (stamp - SmallSite::stamp(0)).seconds();
  return looking_at({-0.1 + 0.3 * t + 0.1 * static_cast<double>(camera), 0.05 * t, 0}, {0.05 * t, 0, 2}, {0, -1, 0});
}

Pose SmallSite::world_from_board(Timestamp stamp) {
  const double t = (stamp - SmallSite::stamp(0)).seconds();
  return {glm::dquat(1, 0, 0, 0), {-0.2 + 0.25 * t, 0.02, 1}};
}

RawMesh SmallSite::mesh() {
  RawMesh mesh;
  // Fronts look along -z, towards the camera; counter-clockwise seen from there (x right, y down).
  mesh.vertices = {{-1.5, -1.5, 2}, {-1.5, 1.5, 2}, {1.5, 1.5, 2}, {1.5, -1.5, 2},
                   {-0.2, -0.2, 0}, {-0.2, 0.2, 0}, {0.2, 0.2, 0}, {0.2, -0.2, 0}};
  mesh.faces = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  mesh.face_part = {0, 1};
  mesh.part_names = {"wall", "board"};
  return mesh;
}

cv::Mat SmallSite::render(std::size_t camera_index, Timestamp stamp) const {
  const Pose world = world_from_camera(camera_index, stamp), board_from_world = world_from_board(stamp).inverse();
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      cv::Vec3d sum(0, 0, 0);
      for (int ray = 0; ray < 16; ++ray) {
        const glm::dvec2 pixel(x + (ray % 4 + 0.5) / 4, y + (ray / 4 + 0.5) / 4);
        sum += colour_along(world.translation, world.rotate(camera.ray_from_pixel(pixel)), board_from_world) / 16;
      }
      for (int c = 0; c < 3; ++c) picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<unsigned char>(sum[c]);
    }
  }
  return picture;
}

void SmallSite::write(const std::filesystem::path& directory) const {
  RecordingWriter::Description description;
  description.name = "small";
  for (std::size_t c = 0; c < cameras; ++c) {
    description.cameras.push_back({cameras == 1 ? "" : c == 0 ? "left" : "right", camera});
  }
  description.scene_file = "scene.obj";
  description.import_options.backdrop = false;
  RecordingWriter writer(directory, description);
  write_obj(mesh(), directory / description.scene_file);
  for (std::size_t i = 0; i < instants; ++i) {
    for (const Timestamp t : {stamp(i), stamp(i) + Duration{50'000'000}}) {
      writer.add_part_pose("board", t, world_from_board(t));
      for (std::size_t c = 0; c < cameras; ++c) writer.add_camera_pose(c, t, world_from_camera(c, t));
    }
    for (std::size_t c = 0; c < cameras; ++c) writer.add_picture(c, stamp(i), render(c, stamp(i)), "png");
  }
  writer.finish();
}

}  // namespace foreview::test
