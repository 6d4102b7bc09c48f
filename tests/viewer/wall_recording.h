#pragma once
#include <cmath>
#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "foreview/recordings/recording.h"
#include "viewer/painted_scene.h"

namespace foreview::test {

/// A recording small enough for tests of the executable: a camera slides along a patterned wall, one picture every
/// 40 ms from 100 s on. The wall is 3 x 2 m at z = 2 and fills every picture.
struct WallRecording {
  static constexpr int kWidth = 120, kHeight = 80;

  static CameraModel camera() { return pinhole(kWidth, kHeight, 110); }
  static Timestamp stamp(int picture) { return {100'000'000'000 + 40'000'000 * static_cast<std::int64_t>(picture)}; }
  static Pose world_from_camera(int picture) { return {{1, 0, 0, 0}, {-0.3 + 0.02 * picture, 0.01 * picture, 0}}; }

  static Rgb wall(double x, double y) {
    const double rings = std::sin(25 * std::hypot(x - 0.2, y + 0.1));
    return {128 + 90 * std::sin(9 * x) * std::cos(7 * y), 128 + 90 * rings, 128 + 90 * std::cos(6 * x + 8 * y)};
  }

  /// What the camera sees; 4 x 4 samples a pixel.
  static cv::Mat truth(int picture) {
    const CameraModel model = camera();
    const Pose pose = world_from_camera(picture);
    cv::Mat result(kHeight, kWidth, CV_8UC3);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        Rgb sum(0);
        for (int s = 0; s < 16; ++s) {
          const int row = s / 4, column = s % 4;
          const glm::dvec3 ray = model.ray_from_pixel({u + (column + 0.5) / 4, v + (row + 0.5) / 4});
          const glm::dvec3 p = pose.translation + ray * (2 / ray.z);
          sum += wall(p.x, p.y);
        }
        const auto byte = [](double value) { return cv::saturate_cast<std::uint8_t>(value / 16); };
        result.at<cv::Vec3b>(v, u) = {byte(sum.b), byte(sum.g), byte(sum.r)};
      }
    }
    return result;
  }

  static void write(const std::filesystem::path& directory, int pictures) {
    std::filesystem::create_directories(directory);
    RecordingWriter::Description description;
    description.name = "wall";
    description.cameras = {{"", camera()}};
    description.scene_file = "scene.obj";
    description.import_options.backdrop = false;
    description.import_options.merge_coplanar = false;
    description.density = 120;
    description.max_texels = 128;
    write_obj(facing_rectangle(3, 2, 2, 6, 4), directory / "scene.obj");
    RecordingWriter writer(directory, description);
    for (int i = 0; i < pictures; ++i) {
      writer.add_camera_pose(0, stamp(i), world_from_camera(i));
      writer.add_picture(0, stamp(i), truth(i), "png");
    }
    writer.finish();
  }
};

}  // namespace foreview::test
