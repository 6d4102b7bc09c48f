#include "foreview/calib/landmark.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>
#include <vector>

namespace foreview {
namespace {

constexpr int kSide = ExpectedLook::kSide;
constexpr int kHalf = kSide / 2;

/// Of the patch's pixels, rows first.
std::size_t index_of(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

constexpr double kNearest = 0.02;      ///< metres in front of the camera
constexpr double kFraction = 8;        ///< ExpectedLook::look is in eighths of 1/255
constexpr double kLeastDeviation = 4;  ///< standard deviation of what is to be recognised, 1/255

double sample(const cv::Mat& grey, const glm::dvec2& at) {
  const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
  const double fx = at.x - x, fy = at.y - y;
  const std::uint8_t *upper = grey.ptr<std::uint8_t>(y) + x, *lower = grey.ptr<std::uint8_t>(y + 1) + x;
  return (1 - fy) * ((1 - fx) * upper[0] + fx * upper[1]) + fy * ((1 - fx) * lower[0] + fx * lower[1]);
}

}  // namespace

std::optional<ExpectedLook> expected_look(const Landmark& landmark, const CameraModel& camera,
                                          const Pose& camera_from_part) {
  const glm::dvec3 now = camera_from_part * landmark.point;
  const glm::dvec3 then = landmark.camera_from_part * landmark.point;
  if (now.z <= kNearest || then.z <= kNearest) return std::nullopt;
  // How the surface is turned decides what neighbouring pixels of then are those of now; over the size of the patch it
  // is taken for a plane and the lens for a linear map.
  const double step = 4 * now.z / camera.focal_length.x;
  const glm::dvec3 axis = std::abs(landmark.normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 tangent = glm::normalize(glm::cross(landmark.normal, axis));
  const glm::dvec3 along_surface[2] = {tangent, glm::cross(landmark.normal, tangent)};
  const glm::dvec2 pixel_now = camera.pixel_from_camera(now), pixel_then = camera.pixel_from_camera(then);
  glm::dmat2 now_from_surface, then_from_surface;
  for (int i = 0; i < 2; ++i) {
    const glm::dvec3 point = landmark.point + step * along_surface[i];
    const glm::dvec3 a = camera_from_part * point, b = landmark.camera_from_part * point;
    if (a.z <= kNearest || b.z <= kNearest) return std::nullopt;
    now_from_surface[i] = camera.pixel_from_camera(a) - pixel_now;
    then_from_surface[i] = camera.pixel_from_camera(b) - pixel_then;
  }
  const double area_now = glm::determinant(now_from_surface), area_then = glm::determinant(then_from_surface);
  // Square on, an area of 4 by 4 pixels. Grazing views are left out, and those whose pixels would average many of the
  // other picture's, or share one.
  if (!(std::abs(area_now) > 2) || !(std::abs(area_then) > 2)) return std::nullopt;
  const double ratio = area_then / area_now;
  if (!(ratio > 0.25 && ratio < 2.5)) return std::nullopt;
  const glm::dmat2 then_from_now = then_from_surface * glm::inverse(now_from_surface);

  ExpectedLook expected;
  expected.pixel = pixel_now;
  std::array<double, kSide * kSide> values{};
  double sum = 0;
  const double limit = 2.0 * Landmark::kReach - 0.01;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const glm::dvec2 offset(x + 0.5 - kHalf, y + 0.5 - kHalf);
      const glm::dvec2 at = glm::dvec2(Landmark::kReach) + then_from_now * offset;
      if (at.x < 0 || at.y < 0 || at.x > limit || at.y > limit) return std::nullopt;
      double& value = values[index_of(x, y, kSide)];
      value = sample(landmark.look, at);
      sum += value;
    }
  }
  const double mean = sum / (kSide * kSide);
  double squares = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    expected.look[i] = static_cast<std::int16_t>(std::lround(kFraction * (values[i] - mean)));
    squares += static_cast<double>(expected.look[i]) * expected.look[i];
  }
  expected.norm = std::sqrt(squares);
  if (expected.norm < kFraction * kSide * kLeastDeviation) return std::nullopt;
  return expected;
}

std::optional<FoundLook> find_look(const ExpectedLook& expected, const cv::Mat& grey, int radius) {
  // The patch's upper left pixel with its corner nearest to the expected place.
  const int left = static_cast<int>(std::lround(expected.pixel.x)) - kHalf - radius;
  const int top = static_cast<int>(std::lround(expected.pixel.y)) - kHalf - radius;
  const int places = 2 * radius + 1;
  if (left < 0 || top < 0 || left + places + kSide > grey.cols || top + places + kSide > grey.rows) return std::nullopt;
  std::vector<double> likeness(index_of(0, places, places));
  int best = 0;
  for (int dy = 0; dy < places; ++dy) {
    for (int dx = 0; dx < places; ++dx) {
      std::int32_t product = 0, sum = 0, squares = 0;
      for (int y = 0; y < kSide; ++y) {
        const std::uint8_t* row = grey.ptr<std::uint8_t>(top + dy + y) + left + dx;
        const std::int16_t* look = &expected.look[index_of(0, y, kSide)];
        for (int x = 0; x < kSide; ++x) {
          const auto value = static_cast<std::int32_t>(row[x]);
          product += look[x] * value;
          sum += value;
          squares += value * value;
        }
      }
      const double variance = squares - static_cast<double>(sum) * sum / (kSide * kSide);
      const int i = dy * places + dx;
      likeness[static_cast<std::size_t>(i)] = variance > 0 ? product / (expected.norm * std::sqrt(variance)) : 0;
      if (likeness[static_cast<std::size_t>(i)] > likeness[static_cast<std::size_t>(best)]) best = i;
    }
  }
  const int bx = best % places, by = best / places;
  if (bx == 0 || by == 0 || bx == places - 1 || by == places - 1) return std::nullopt;
  const auto at = [&](int x, int y) { return likeness[index_of(x, y, places)]; };
  const auto vertex = [](double before, double middle, double after) {
    const double curvature = before - 2 * middle + after;
    return curvature < 0 ? std::clamp((before - after) / (2 * curvature), -0.5, 0.5) : 0.0;
  };
  FoundLook found;
  found.likeness = at(bx, by);
  found.pixel =
      glm::dvec2(left + bx + kHalf, top + by + kHalf) + glm::dvec2(vertex(at(bx - 1, by), at(bx, by), at(bx + 1, by)),
                                                                   vertex(at(bx, by - 1), at(bx, by), at(bx, by + 1)));
  return found;
}

}  // namespace foreview
