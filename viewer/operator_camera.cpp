#include "foreview/viewer/operator_camera.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace foreview {
namespace {

constexpr double kHalfTurn = 3.14159265358979323846;
constexpr double kSteepest = 0.5 * kHalfTurn - 1e-3;  // radians up or down that input leads to
constexpr double kOverviewElevation = 0.7;            // radians above the horizon
constexpr double kSmallestStep = 1.0 / 240;           // seconds, where motions do not commute
const glm::dvec3 kRight{1, 0, 0}, kDown{0, 1, 0}, kForward{0, 0, 1};

/// Turned about `up` to the right, and about the camera's own x axis down: in either order.
glm::dquat turned(const glm::dquat& rotation, const glm::dvec3& up, double right, double down) {
  return glm::normalize(glm::angleAxis(-right, up) * rotation * glm::angleAxis(-down, kRight));
}

/// Of a turn downwards the part that does not lead over the vertical. A camera that is over it already may do anything.
double keep_upright(const glm::dquat& rotation, const glm::dvec3& up, double down) {
  const double steepness = std::atan2(-glm::dot(rotation * kForward, up), -glm::dot(rotation * kDown, up));
  if (std::abs(steepness) > 0.5 * kHalfTurn + 1e-6) return down;
  return std::clamp(down, std::min(0.0, -kSteepest - steepness), std::max(0.0, kSteepest - steepness));
}

/// Takes the share that is due out of what is left.
template <class Amount>
Amount take(Amount& left, double share) {
  const Amount taken = left * share;
  left -= taken;
  return taken;
}

template <class Vector>
bool is_zero(const Vector& v) {
  return v == Vector(0);
}

}  // namespace

CameraModel with_field_of_view(const CameraModel& camera, std::optional<double> radians) {
  CameraModel result = camera.undistorted();
  if (!radians) return result;
  const double angle = std::clamp(*radians, kLeastFieldOfView, kGreatestFieldOfView);
  const double scale = 0.5 * camera.height / std::tan(0.5 * angle) / camera.focal_length.y;
  result.focal_length *= scale;
  // A principal point off the middle would make "from top to bottom" mean something else at every angle.
  result.principal_point = {0.5 * camera.width, 0.5 * camera.height};
  return result;
}

double field_of_view(const CameraModel& camera) {
  return std::atan(camera.principal_point.y / camera.focal_length.y) +
         std::atan((camera.height - camera.principal_point.y) / camera.focal_length.y);
}

OperatorCamera::OperatorCamera(const CameraSurroundings& surroundings) : surroundings_(surroundings) {}

Pose OperatorCamera::mode_pose() const {
  switch (mode_) {
    case CameraMode::follow:
      return recorded_;
    case CameraMode::look_around: {
      const double down = keep_upright(recorded_.rotation, surroundings_.up, turn_.y);
      return {turned(recorded_.rotation, surroundings_.up, turn_.x, down), recorded_.translation};
    }
    case CameraMode::free:
    case CameraMode::overview:
      break;
  }
  return {rotation_, pivot_ - rotation_ * pivot_in_camera_};
}

Pose OperatorCamera::pose() const {
  if (transition_left_ <= 0) return mode_pose();
  const double done = 1 - transition_left_ / kTransition;
  return mode_pose() * interpolate(transition_offset_, Pose(), done * done * (3 - 2 * done));
}

/// Free, from here. The pivot lies ahead, about as far as the scene does.
void OperatorCamera::place(const Pose& pose) {
  rotation_ = pose.rotation;
  const double ahead = glm::dot(surroundings_.centre - pose.translation, rotation_ * kForward);
  pivot_in_camera_ = {0, 0, std::clamp(ahead, 0.2 * surroundings_.radius, 4 * surroundings_.radius)};
  pivot_ = pose.translation + rotation_ * pivot_in_camera_;
}

void OperatorCamera::set_mode(CameraMode mode) {
  const bool again = mode == mode_;
  const Pose before = pose();
  orbit_left_ = look_left_ = pan_left_ = glm::dvec2(0);
  dolly_left_ = roll_left_ = 0;
  velocity_ = wanted_velocity_ = glm::dvec3(0);
  turn_ = glm::dvec2(0);
  mode_ = mode;
  if (mode == CameraMode::overview) place(overview_pose(recorded_, field_of_view_));
  if (mode == CameraMode::free) place(again ? recorded_ : before);
  transition_offset_ = mode_pose().inverse() * before;
  transition_left_ = kTransition;
}

void OperatorCamera::advance(double seconds, const Pose& recorded) {
  recorded_ = recorded;
  double left = std::max(seconds, 0.0);
  transition_left_ = std::max(transition_left_ - left, 0.0);
  const bool turns = !is_zero(orbit_left_) || !is_zero(look_left_) || roll_left_ != 0;
  const bool moves = !is_zero(pan_left_) || !is_zero(velocity_) || !is_zero(wanted_velocity_) || dolly_left_ != 0;
  const double rest_of_motion = 60 * kSmoothing;
  while (turns && moves && left > kSmallestStep && seconds - left < rest_of_motion) {
    take_up(kSmallestStep);
    left -= kSmallestStep;
  }
  take_up(left);
}

void OperatorCamera::take_up(double seconds) {
  const double share = -std::expm1(-seconds / kSmoothing);
  // What nobody would see is over: is_moving() comes to an end.
  const auto settle = [](auto& left, double nothing) {
    if (glm::length(left) < nothing) left *= 0.0;
  };
  const glm::dvec2 orbit = take(orbit_left_, share), look = take(look_left_, share), pan = take(pan_left_, share);
  const double dolly = take(dolly_left_, share), roll = take(roll_left_, share);
  const glm::dvec3 flown = wanted_velocity_ * seconds + (velocity_ - wanted_velocity_) * (kSmoothing * share);
  velocity_ += (wanted_velocity_ - velocity_) * share;
  for (glm::dvec2* angles : {&orbit_left_, &look_left_}) settle(*angles, 1e-6);
  settle(pan_left_, 1e-7 * surroundings_.radius);
  settle(dolly_left_, 1e-6);
  settle(roll_left_, 1e-6);
  if (is_zero(wanted_velocity_)) settle(velocity_, 1e-6 * surroundings_.radius);

  if (mode_ == CameraMode::follow) return;
  if (mode_ == CameraMode::look_around) {
    turn_ += orbit + look;
    turn_.y = keep_upright(recorded_.rotation, surroundings_.up, turn_.y);
    return;
  }
  const glm::dvec3& up = surroundings_.up;
  rotation_ = turned(rotation_, up, orbit.x, keep_upright(rotation_, up, orbit.y));
  pivot_in_camera_ *= std::exp(dolly);
  if (!is_zero(look) || roll != 0) {
    const glm::dvec3 position = pivot_ - rotation_ * pivot_in_camera_;
    rotation_ = turned(rotation_, up, look.x, keep_upright(rotation_, up, look.y));
    rotation_ = glm::normalize(rotation_ * glm::angleAxis(roll, kForward));
    pivot_ = position + rotation_ * pivot_in_camera_;
  }
  pivot_ += rotation_ * (flown - glm::dvec3(pan, 0));
}

Pose OperatorCamera::pose_ahead(double seconds, const Pose& recorded) const {
  OperatorCamera later = *this;
  later.advance(seconds, recorded);
  return later.pose();
}

CameraMotion OperatorCamera::motion() const {
  constexpr double kStep = 1e-4;
  const Pose here = pose(), there = pose_ahead(kStep, recorded_);
  glm::dquat turn = there.rotation * glm::conjugate(here.rotation);
  if (turn.w < 0) turn = -turn;
  return {(there.translation - here.translation) / kStep, glm::dvec3(turn.x, turn.y, turn.z) * (2 / kStep)};
}

bool OperatorCamera::is_moving() const {
  return transition_left_ > 0 || !is_zero(orbit_left_) || !is_zero(look_left_) || !is_zero(pan_left_) ||
         dolly_left_ != 0 || roll_left_ != 0 || !is_zero(velocity_) || !is_zero(wanted_velocity_);
}

void OperatorCamera::orbit(double right, double down) {
  if (mode_ == CameraMode::follow) set_mode(CameraMode::look_around);
  orbit_left_ += glm::dvec2(right, down);
}

void OperatorCamera::look(double right, double down) {
  if (mode_ == CameraMode::follow) set_mode(CameraMode::look_around);
  look_left_ += glm::dvec2(right, down);
}

void OperatorCamera::pan(double right, double down) {
  pan_left_ += glm::dvec2(right, down);
}

void OperatorCamera::dolly(double factor) {
  if (factor > 0) dolly_left_ += std::log(factor);
}

void OperatorCamera::fly(const glm::dvec3& velocity) {
  wanted_velocity_ = velocity;
}

void OperatorCamera::roll(double angle) {
  roll_left_ += angle;
}

void OperatorCamera::level() {
  const double right = glm::dot(rotation_ * kRight, surroundings_.up);
  const double down = glm::dot(rotation_ * kDown, surroundings_.up);
  roll_left_ = std::atan2(right, -down);
}

void OperatorCamera::set_pivot(const glm::dvec3& point_in_world) {
  const glm::dvec3 position = pivot_ - rotation_ * pivot_in_camera_;
  pivot_ = point_in_world;
  pivot_in_camera_ = glm::conjugate(rotation_) * (pivot_ - position);
}

glm::dvec3 OperatorCamera::pivot() const {
  return pivot_;
}

double OperatorCamera::metres_per_pixel(const CameraModel& camera) const {
  return std::max(pivot_in_camera_.z, 0.01 * surroundings_.radius) / camera.focal_length.y;
}

void OperatorCamera::apply(const ViewChoice& choice, const CameraModel& camera, const Pose& recorded) {
  recorded_ = recorded;
  set_field_of_view(foreview::field_of_view(with_field_of_view(camera, choice.field_of_view)));
  set_mode(choice.camera);
  turn_ = choice.turn;
  if (choice.camera == CameraMode::free) place(choice.pose.value_or(recorded));
  if (choice.camera == CameraMode::overview && choice.pose) place(*choice.pose);
  transition_left_ = 0;
}

void OperatorCamera::store(ViewChoice& choice) const {
  choice.camera = mode_;
  choice.turn = mode_ == CameraMode::look_around ? turn_ : glm::dvec2(0);
  choice.pose.reset();
  if (mode_ == CameraMode::free || mode_ == CameraMode::overview) choice.pose = mode_pose();
}

Pose OperatorCamera::overview_pose(const Pose& recorded, double field_of_view) const {
  const glm::dvec3& up = surroundings_.up;
  const auto level_part = [&](const glm::dvec3& v) { return v - glm::dot(v, up) * up; };
  // Where the recorded camera looks; or, where it looks straight down, what its picture has at the top.
  glm::dvec3 heading = level_part(recorded.rotate(kForward));
  if (glm::length(heading) < 0.2) heading = level_part(recorded.rotate(-kDown));
  if (glm::length(heading) < 1e-6) heading = level_part(recorded.rotate(kRight));
  heading = glm::normalize(heading);
  // The ball around scene and camera.
  glm::dvec3 centre = surroundings_.centre;
  double radius = surroundings_.radius;
  const double away = glm::distance(centre, recorded.translation);
  if (away > radius) {
    centre = glm::mix(centre, recorded.translation, 0.5 * (away - radius) / away);
    radius = 0.5 * (away + radius);
  }
  const glm::dvec3 direction = std::cos(kOverviewElevation) * heading - std::sin(kOverviewElevation) * up;
  const double angle = std::clamp(field_of_view, kLeastFieldOfView, kGreatestFieldOfView);
  return looking_at(centre - direction * (radius / std::sin(0.5 * angle)), centre, up);
}

}  // namespace foreview
