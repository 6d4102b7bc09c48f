#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"

namespace foreview {

/// A picture that landmarks are tied to.
struct Keyframe {
  std::vector<Pose> part_from_recorded;  ///< by part: where the camera was recorded to be, in the part's frame
  Pose rest;  ///< mounted_from_registered: where it was, seen from where record and mount have it
};

/// A place on the model's surface that is found again in pictures by how it looked when it was first seen.
struct Landmark {
  static constexpr int kReach = 20;  ///< pixels around its own that are kept of the picture it was first seen in

  std::uint32_t part = 0;
  glm::dvec3 normal{0, 0, 1};        ///< of the surface around it: unit length, part frame ...
  double offset = 0;                 ///< ... dot(normal, p) == offset, metres
  std::shared_ptr<Keyframe> anchor;  ///< where it was first seen ...
  glm::dvec2 pixel{0};               ///< ... at this pixel's centre (with the lens's distortion) ...
  cv::Mat look;                      ///< ... and so: CV_8UC1, 2 kReach + 1 square, around `pixel`
  struct Observation {
    std::shared_ptr<Keyframe> keyframe;
    glm::dvec2 pixel{0};  ///< with the lens's distortion
  };
  std::deque<Observation> observations;  ///< in later keyframes
  std::size_t tried = 0, found = 0;      ///< in later pictures
  std::size_t last_found = 0;            ///< number of the picture

  // Where the anchor's line of sight meets the surface, as mount, camera and the anchor's rest are taken now:
  glm::dvec3 point{0};    ///< part frame
  Pose camera_from_part;  ///< of the anchor
};

/// Where a landmark should be in a picture, and what it should look like there.
struct ExpectedLook {
  static constexpr int kSide = 16;  ///< pixels; the landmark is at the corner between the four in the middle
  glm::dvec2 pixel{0};
  std::array<std::int16_t, kSide * kSide> look{};  ///< rows; zero mean
  double norm = 0;                                 ///< root of the sum of squares
};

/// `camera_from_part`: of the picture. None where the landmark is behind the camera, or so much nearer, farther or
/// turned that its look is not known, or where it would have (almost) none.
[[nodiscard]] std::optional<ExpectedLook> expected_look(const Landmark& landmark, const CameraModel& camera,
                                                        const Pose& camera_from_part);

struct FoundLook {
  glm::dvec2 pixel{0};
  double likeness = 0;  ///< normalised cross-correlation, -1..1
};
/// Where within `radius` pixels of its expected place a picture (CV_8UC1) looks most like it, to a part of a pixel.
/// None where the picture's border is too near, or the best place is at the search's edge.
[[nodiscard]] std::optional<FoundLook> find_look(const ExpectedLook& expected, const cv::Mat& grey, int radius);

}  // namespace foreview
