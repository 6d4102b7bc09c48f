#include "foreview/calib/registration_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "foreview/calib/median.h"

namespace foreview {
namespace {

constexpr int kCommon = 9;  ///< unknowns: mount 0..5, focal length 6, principal point 7, 8
constexpr int kRest = 6;

glm::dmat3 rotation_of(const Pose& pose) {
  return glm::mat3_cast(pose.rotation);
}

/// How distort() changes what it is given.
glm::dmat2 distortion_slope(const CameraModel& camera, const glm::dvec2& normalised) {
  if (!camera.is_distorted()) return glm::dmat2(1);
  constexpr double kStep = 1e-6;
  const glm::dvec2 middle = camera.distort(normalised);
  return {(camera.distort(normalised + glm::dvec2(kStep, 0)) - middle) / kStep,
          (camera.distort(normalised + glm::dvec2(0, kStep)) - middle) / kStep};
}

/// Velocity of a point when its frame moves by unit `i` of a motion vector.
glm::dvec3 velocity(const glm::dvec3& point, int i) {
  glm::dvec3 axis(0);
  axis[i % 3] = 1;
  return i < 3 ? axis : glm::cross(axis, point);
}

/// One observation's distance from where it should be, and how that changes with what it depends on.
struct Line {
  glm::dvec2 error{0};  ///< pixels: observed less expected
  double distance = 0;
  glm::dvec2 common[kCommon];  ///< slopes of the expected pixel
  glm::dvec2 observer[kRest];
  glm::dvec2 anchor[kRest];
};

/// The slopes of a landmark's point that its observations share.
struct AnchorSlopes {
  glm::dvec3 common[kCommon];  ///< part frame
  glm::dvec3 anchor[kRest];
};

class Fit {
 public:
  Fit(CameraRegistration& common, const CameraModel& nominal, std::span<Landmark> landmarks,
      std::span<const std::shared_ptr<Keyframe>> free, const RegistrationTolerances& tolerances)
      : common_(common), nominal_(nominal), landmarks_(landmarks), free_(free), tolerances_(tolerances) {
    for (std::size_t i = 0; i < free.size(); ++i) columns_[free[i].get()] = kCommon + kRest * static_cast<int>(i);
  }

  /// Distances as things are now, in no order.
  [[nodiscard]] std::vector<double> distances() const {
    const CameraModel camera = common_.camera(nominal_);
    std::vector<double> result;
    for (const Landmark& landmark : landmarks_) {
      for (const auto& observation : landmark.observations) {
        const glm::dvec3 q = camera_from_part(landmark, *observation.keyframe) * landmark.point;
        if (q.z > 0) result.push_back(glm::distance(observation.pixel, camera.pixel_from_camera(q)));
      }
    }
    return result;
  }

  /// One Gauss-Newton step; weights end at `reach` pixels.
  void step(double reach) {
    const int size = kCommon + kRest * static_cast<int>(free_.size());
    cv::Mat_<double> normal(size, size, 0.0), right(size, 1, 0.0);
    const CameraModel camera = common_.camera(nominal_);
    for (const Landmark& landmark : landmarks_) {
      if (landmark.observations.empty()) continue;
      const AnchorSlopes slopes = anchor_slopes(landmark, camera);
      for (const auto& observation : landmark.observations) {
        Line line;
        if (!reckon(landmark, observation, camera, slopes, reach, line)) continue;
        const double rest = 1 - line.distance * line.distance / (reach * reach);
        add(line, rest * rest / (tolerances_.pixel * tolerances_.pixel), column_of(*observation.keyframe),
            column_of(*landmark.anchor), normal, right);
      }
    }
    add_tolerances(normal, right);
    cv::completeSymm(normal, true);
    cv::Mat_<double> solution;
    if (!cv::solve(normal, right, solution, cv::DECOMP_CHOLESKY) || !cv::checkRange(solution)) return;
    apply(solution);
    const CameraModel fitted = common_.camera(nominal_);
    for (Landmark& landmark : landmarks_) place_landmark(landmark, common_, fitted);
  }

 private:
  /// First column of a free keyframe, or -1.
  [[nodiscard]] int column_of(const Keyframe& keyframe) const {
    const auto found = columns_.find(&keyframe);
    return found == columns_.end() ? -1 : found->second;
  }
  [[nodiscard]] Pose camera_from_part(const Landmark& landmark, const Keyframe& keyframe) const {
    return (keyframe.part_from_recorded[landmark.part] * common_.recorded_from_mounted * keyframe.rest).inverse();
  }

  [[nodiscard]] AnchorSlopes anchor_slopes(const Landmark& landmark, const CameraModel& camera) const {
    AnchorSlopes slopes;
    const glm::dvec3 in_camera = landmark.camera_from_part * landmark.point;
    const glm::dvec2 normalised = glm::dvec2(in_camera) / in_camera.z;
    const glm::dmat3 part_from_camera = glm::transpose(rotation_of(landmark.camera_from_part));
    const glm::dvec3 along = part_from_camera * glm::dvec3(normalised, 1);
    const double across = glm::dot(landmark.normal, along);
    // What moves the line of sight moves the point where it meets the surface, along the surface.
    const auto on_surface = [&](const glm::dvec3& moved) {
      return moved - along * (glm::dot(landmark.normal, moved) / across);
    };
    const Pose part_from_mounted = landmark.anchor->part_from_recorded[landmark.part] * common_.recorded_from_mounted;
    const glm::dmat3 mounted = rotation_of(part_from_mounted);
    const glm::dvec3 in_mounted = landmark.anchor->rest * in_camera;
    for (int i = 0; i < kRest; ++i) {
      slopes.anchor[i] = on_surface(part_from_camera * velocity(in_camera, i));
      slopes.common[i] = on_surface(mounted * velocity(in_mounted, i));
    }
    const glm::dmat2 undistorting = glm::inverse(distortion_slope(camera, normalised));
    const glm::dvec2 shift = nominal_.focal_length / camera.focal_length;
    const glm::dvec2 distorted = (landmark.pixel - camera.principal_point) / camera.focal_length;
    const glm::dvec2 rays[3] = {-(undistorting * distorted), -(undistorting * glm::dvec2(shift.x, 0)),
                                -(undistorting * glm::dvec2(0, shift.y))};
    for (int i = 0; i < 3; ++i) {
      slopes.common[6 + i] = on_surface(part_from_camera * glm::dvec3(in_camera.z * rays[i], 0));
    }
    return slopes;
  }

  /// False where it is out of reach.
  bool reckon(const Landmark& landmark, const Landmark::Observation& observation, const CameraModel& camera,
              const AnchorSlopes& slopes, double reach, Line& line) const {
    const Keyframe& keyframe = *observation.keyframe;
    const Pose from_part = camera_from_part(landmark, keyframe);
    const glm::dvec3 q = from_part * landmark.point;
    if (!(q.z > 0)) return false;
    const glm::dvec2 normalised = glm::dvec2(q) / q.z, distorted = camera.distort(normalised);
    line.error = observation.pixel - (camera.focal_length * distorted + camera.principal_point);
    line.distance = glm::length(line.error);
    if (!(line.distance < reach)) return false;
    const glm::dmat2 slope = distortion_slope(camera, normalised);
    const auto seen = [&](const glm::dvec3& moved) {  // the pixel's motion when q moves so
      return camera.focal_length * (slope * ((glm::dvec2(moved) - normalised * moved.z) / q.z));
    };
    const glm::dmat3 turn = rotation_of(from_part), unrest = glm::transpose(rotation_of(keyframe.rest));
    const glm::dvec3 in_mounted = keyframe.rest * q;
    for (int i = 0; i < kRest; ++i) {
      line.observer[i] = seen(-velocity(q, i));
      line.anchor[i] = seen(turn * slopes.anchor[i]);
      line.common[i] = seen(turn * slopes.common[i] - unrest * velocity(in_mounted, i));
    }
    for (int i = 6; i < kCommon; ++i) line.common[i] = seen(turn * slopes.common[i]);
    line.common[6] += camera.focal_length * distorted;
    line.common[7].x += nominal_.focal_length.x;
    line.common[8].y += nominal_.focal_length.y;
    return true;
  }

  /// Into the lower triangle.
  static void add(const Line& line, double weight, int observer, int anchor, cv::Mat_<double>& normal,
                  cv::Mat_<double>& right) {
    struct Column {
      int index;
      const glm::dvec2* slope;
    };
    std::array<Column, kCommon + 2 * kRest> columns{};
    std::size_t count = 0;
    for (int i = 0; i < kCommon; ++i) columns[count++] = {i, &line.common[i]};
    for (int i = 0; i < kRest && observer >= 0; ++i) columns[count++] = {observer + i, &line.observer[i]};
    for (int i = 0; i < kRest && anchor >= 0; ++i) columns[count++] = {anchor + i, &line.anchor[i]};
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec2 slope = weight * *columns[i].slope;
      right(columns[i].index, 0) += glm::dot(slope, line.error);
      for (std::size_t j = 0; j < count; ++j) {
        if (columns[j].index <= columns[i].index) {
          normal(columns[i].index, columns[j].index) += glm::dot(slope, *columns[j].slope);
        }
      }
    }
  }

  void add_tolerances(cv::Mat_<double>& normal, cv::Mat_<double>& right) const {
    const auto hold = [&](int column, double value, double tolerance) {
      normal(column, column) += 1 / (tolerance * tolerance);
      right(column, 0) -= value / (tolerance * tolerance);
    };
    const MotionVector mount = vector_of(common_.recorded_from_mounted);
    for (int i = 0; i < kRest; ++i) {
      hold(i, mount[static_cast<std::size_t>(i)], i < 3 ? tolerances_.mount_translation : tolerances_.mount_rotation);
    }
    hold(6, common_.focal_length, tolerances_.focal_length);
    hold(7, common_.principal_point.x, tolerances_.principal_point);
    hold(8, common_.principal_point.y, tolerances_.principal_point);
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const MotionVector rest = vector_of(free_[k]->rest);
      for (int i = 0; i < kRest; ++i) {
        hold(kCommon + kRest * static_cast<int>(k) + i, rest[static_cast<std::size_t>(i)],
             i < 3 ? tolerances_.rest_translation : tolerances_.rest_rotation);
      }
    }
  }

  void apply(const cv::Mat_<double>& solution) {
    const auto motion_at = [&](int column) {
      MotionVector vector{};
      for (int i = 0; i < kRest; ++i) vector[static_cast<std::size_t>(i)] = solution(column + i, 0);
      return motion_from(vector);
    };
    common_.recorded_from_mounted = common_.recorded_from_mounted * motion_at(0);
    common_.focal_length += solution(6, 0);
    common_.principal_point += glm::dvec2(solution(7, 0), solution(8, 0));
    for (std::size_t k = 0; k < free_.size(); ++k) {
      free_[k]->rest = free_[k]->rest * motion_at(kCommon + kRest * static_cast<int>(k));
    }
  }

  CameraRegistration& common_;
  const CameraModel& nominal_;
  std::span<Landmark> landmarks_;
  std::span<const std::shared_ptr<Keyframe>> free_;
  const RegistrationTolerances& tolerances_;
  std::unordered_map<const Keyframe*, int> columns_;
};

/// Where the landmark's pixel sees its surface.
std::optional<glm::dvec3> on_surface(const Landmark& landmark, const Pose& part_from_camera,
                                     const CameraModel& camera) {
  const glm::dvec3 along = part_from_camera.rotate(camera.ray_from_pixel(landmark.pixel));
  const double z =
      (landmark.offset - glm::dot(landmark.normal, part_from_camera.translation)) / glm::dot(landmark.normal, along);
  if (!std::isfinite(z) || z <= 0) return std::nullopt;
  return part_from_camera.translation + z * along;
}

}  // namespace

CameraModel CameraRegistration::camera(const CameraModel& nominal) const {
  CameraModel result = nominal;
  result.focal_length *= std::exp(focal_length);
  result.principal_point += nominal.focal_length * principal_point;
  return result;
}

Pose motion_from(const MotionVector& vector) {
  const glm::dvec3 turn(vector[3], vector[4], vector[5]);
  const double angle = glm::length(turn);
  Pose pose;
  pose.translation = {vector[0], vector[1], vector[2]};
  if (angle > 0) pose.rotation = glm::angleAxis(angle, turn / angle);
  return pose;
}

MotionVector vector_of(const Pose& motion) {
  const glm::dquat q = motion.rotation.w < 0 ? -motion.rotation : motion.rotation;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const double length = glm::length(axis);
  const glm::dvec3 turn = length > 1e-12 ? axis * (2 * std::atan2(length, q.w) / length) : 2.0 * axis;
  return {motion.translation.x, motion.translation.y, motion.translation.z, turn.x, turn.y, turn.z};
}

bool place_landmark(Landmark& landmark, const CameraRegistration& common, const CameraModel& camera) {
  const Pose part_from_camera =
      landmark.anchor->part_from_recorded[landmark.part] * common.recorded_from_mounted * landmark.anchor->rest;
  const auto point = on_surface(landmark, part_from_camera, camera);
  if (!point) return false;
  landmark.point = *point;
  landmark.camera_from_part = part_from_camera.inverse();
  return true;
}

double tukey_reach(const std::vector<double>& distances) {
  constexpr double kLeast = 4;
  constexpr double kDeviationFromMedian = 1.4826;  // of a normal distribution
  return std::max(kLeast, 3 * kDeviationFromMedian * median(distances));
}

double error_of_record(const CameraModel& nominal, std::span<const Landmark> landmarks) {
  std::vector<double> distances;
  for (const Landmark& landmark : landmarks) {
    if (landmark.observations.empty()) continue;
    const Pose& anchor = landmark.anchor->part_from_recorded[landmark.part];
    const auto point = on_surface(landmark, anchor, nominal);
    for (const auto& observation : landmark.observations) {
      if (!point) break;
      const glm::dvec3 q = observation.keyframe->part_from_recorded[landmark.part].inverse() * *point;
      if (q.z > 0) distances.push_back(glm::distance(observation.pixel, nominal.pixel_from_camera(q)));
    }
  }
  return median(std::move(distances));
}

double fit_registration(CameraRegistration& common, const CameraModel& nominal, std::span<Landmark> landmarks,
                        std::span<const std::shared_ptr<Keyframe>> free, const RegistrationTolerances& tolerances,
                        int steps) {
  Fit fit(common, nominal, landmarks, free, tolerances);
  for (int i = 0; i < steps; ++i) {
    fit.step(tukey_reach(fit.distances()));
  }
  return median(fit.distances());
}

}  // namespace foreview
