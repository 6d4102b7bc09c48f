#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "foreview/scene/camera_model.h"

namespace foreview::synthetic {

inline constexpr int kSamplesPerPixel = 4;
inline constexpr int kBlock = 8;        ///< pixels, finest step of the search
inline constexpr int kSuperBlock = 64;  ///< pixels, first step of the search

/// Where a camera's samples look, lens distortion taken out: rays (x, y, 1) in the optical frame. Four samples a pixel
/// on a rotated grid, and the pixel's centre. Rows are padded to whole blocks.
struct RayTable {
  explicit RayTable(const CameraModel& camera);

  struct Bounds {
    float low_x, high_x, low_y, high_y;
  };
  int width, height;  ///< pixels of the picture
  int stride;         ///< pixels of a row, a multiple of kBlock
  std::array<std::vector<float>, kSamplesPerPixel> x, y;
  std::vector<float> centre_x, centre_y;
  int blocks_across, super_across;
  std::vector<Bounds> blocks, super_blocks;  ///< what the samples of a block span
};

/// A face that may be seen: its corners in the optical frame, metres, counter-clockwise from the front.
struct ViewFace {
  std::uint32_t id = 0;
  std::span<const glm::dvec3> corners;
};

/// The nearest front face at every sample. Nothing needs clipping: a sample's ray is inside a convex face if it lies on
/// the inner side of every plane through the eye and an edge, which also holds for faces that reach behind the camera.
/// Faces with a common edge (same vertices) leave no gap.
struct Visibility {
  explicit Visibility(const RayTable& rays);
  /// Draws one face; back faces are left out (solids are closed).
  void draw(const RayTable& rays, const ViewFace& face);

  std::array<std::vector<float>, kSamplesPerPixel> inverse_z;    ///< 1/m, 0 where nothing is
  std::array<std::vector<std::int32_t>, kSamplesPerPixel> face;  ///< id, or -1
};

}  // namespace foreview::synthetic
