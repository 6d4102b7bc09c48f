#pragma once
#include <cstddef>
#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "foreview/recordings/recording.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::test {

/// A small site whose pictures are computed ray by ray, with no code of the product but poses and the camera model: a
/// wall, 3 m wide and high at z = 2 m, and a board of 0.4 m that slides to the right 1 m in front of it, both with a
/// smooth pattern. The camera moves sideways, and looks at the wall. One instant every 100 ms.
struct SmallSite {
  CameraModel camera;
  std::size_t cameras = 1;  ///< a second one stands 0.1 m to the right
  std::size_t instants = 10;
  SmallSite();

  [[nodiscard]] static Timestamp stamp(std::size_t instant);
  [[nodiscard]] static Pose world_from_camera(std::size_t camera, Timestamp stamp);
  [[nodiscard]] static Pose world_from_board(Timestamp stamp);
  [[nodiscard]] static RawMesh mesh();
  /// The mean of 4x4 rays per pixel, with the camera's lens distortion.
  [[nodiscard]] cv::Mat render(std::size_t camera_index, Timestamp stamp) const;
  /// Writes a recording, as PNG; the camera's poses are written also halfway between instants.
  void write(const std::filesystem::path& directory) const;
};

}  // namespace foreview::test
