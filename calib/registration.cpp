#include "foreview/calib/registration.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "foreview/calib/median.h"

namespace foreview {
namespace {

constexpr int kColumns = 8, kRows = 6;        ///< cells that landmarks are spread over
constexpr std::size_t kPerCell = 4;           ///< landmarks looked for, and wanted
constexpr int kRadius = 8, kWideRadius = 14;  ///< pixels searched around the expected place; where the last picture
                                              ///< told little
constexpr double kLikeness = 0.8;
constexpr double kFitting = 3;                    ///< pixels
constexpr std::size_t kEnough = 12;               ///< fitting landmarks
constexpr std::size_t kEnoughObservations = 100;  ///< to judge the record by
constexpr std::size_t kEnoughKeyframes = 24;      ///< before: from a short way, what is constant is found badly
constexpr std::size_t kKeyframeEvery = 4;         ///< pictures
constexpr std::size_t kWindow = 40;               ///< keyframes whose rests are fitted together
constexpr std::size_t kLandmarks = 2000, kObservations = 16;
constexpr int kFitSteps = 2, kFirstFitSteps = 8;
constexpr double kFitsNoMore = 1, kFitsAgain = 0.7;  ///< pixels: RegistrationStatus::error_recorded
constexpr double kStep = 0.01;  ///< metres, radians: tolerance of a pose's change since the last picture

int cell_of(const glm::dvec2& pixel, const cv::Mat& grey) {
  return static_cast<int>(pixel.y * kRows / grey.rows) * kColumns + static_cast<int>(pixel.x * kColumns / grey.cols);
}

bool is_inside(const glm::dvec2& pixel, const cv::Mat& grey, double margin) {
  return pixel.x >= margin && pixel.y >= margin && pixel.x < grey.cols - margin && pixel.y < grey.rows - margin;
}

}  // namespace

Registration::Registration(const PolygonModel& model, const RayCaster& rays, const RegistrationTolerances& tolerances)
    : model_(&model), rays_(&rays), tolerances_(tolerances) {}

void Registration::correct(CameraFrame& frame) {
  const Pose recorded = frame.state.world_from_camera;
  place(frame);
  if (!lesson_) return;
  const bool is_newest = lesson_->is_newest;
  learn();
  give(frame, recorded, (is_newest ? newest_ : earlier_)->rest);
}

/// Of a picture with this rest.
void Registration::give(CameraFrame& frame, const Pose& recorded, const Pose& rest) {
  frame.camera = *camera_;
  given_camera_ = camera_;
  frame.state.world_from_camera = recorded;
  registered_from_recorded_ = {};
  if (!status_.is_correcting) return;
  frame.state.world_from_camera = recorded * common_.recorded_from_mounted * rest;
  registered_from_recorded_ = frame.state.world_from_camera * recorded.inverse();
}

void Registration::leap() {
  newest_.reset();
  earlier_.reset();
}

Registration::Track Registration::nearest_track(Timestamp stamp) const {
  const auto distance = [&](const Track& track) { return std::abs((stamp - track.stamp).nanoseconds); };
  if (newest_ && earlier_) return distance(*earlier_) < distance(*newest_) ? *earlier_ : *newest_;
  return newest_.value_or(Track());
}

void Registration::place(CameraFrame& frame) {
  if (!nominal_ || nominal_->width != frame.camera.width || nominal_->height != frame.camera.height ||
      nominal_->focal_length != frame.camera.focal_length ||
      nominal_->principal_point != frame.camera.principal_point ||
      nominal_->distortion_model != frame.camera.distortion_model || nominal_->distortion != frame.camera.distortion) {
    *this = Registration(*model_, *rays_, tolerances_);
    nominal_ = camera_ = frame.camera;
  }
  lesson_.reset();
  ++status_.pictures;
  const bool is_newest = !newest_ || frame.state.stamp >= newest_->stamp;
  Track track = nearest_track(frame.state.stamp);
  track.stamp = frame.state.stamp;
  const CaptureState recorded = frame.state;
  frame.camera = *camera_;
  const bool is_keyframe = status_.pictures % kKeyframeEvery == 1;
  const bool is_judged = keyframes_made_ >= kEnoughKeyframes;
  if (status_.is_correcting || is_keyframe || !is_judged) {
    ++status_.searched;
    cv::Mat grey;
    cv::cvtColor(frame.picture, grey, cv::COLOR_BGR2GRAY);
    cv::GaussianBlur(grey, grey, cv::Size(3, 3), 0);
    const std::vector<Sighting> sightings = find_landmarks(frame, grey, track);
    const Pose rest = fit_picture(frame, sightings, track.rest);
    const Pose camera_from_world = (recorded.world_from_camera * common_.recorded_from_mounted * rest).inverse();
    std::vector<Sighting> fitting;
    std::vector<double> left;
    for (const Sighting& sighting : sightings) {
      const glm::dvec3 at = camera_from_world * sighting.point_in_world;
      left.push_back(at.z > 0 ? glm::length(camera_->focal_length * (glm::dvec2(at) / at.z - sighting.ray)) : 1e9);
      if (left.back() > kFitting) continue;
      Landmark& landmark = landmarks_[sighting.landmark];
      ++landmark.found;
      landmark.last_found = status_.pictures;
      fitting.push_back(sighting);
    }
    track.expected = status_.expected;
    track.fitting = status_.fitting = fitting.size();
    status_.found = sightings.size();
    status_.error_registered = median(left);
    if (fitting.size() >= kEnough) {
      if (status_.is_correcting) track.rest = rest;
      ++status_.registered;
    }
    if (is_keyframe) lesson_ = Lesson{recorded, grey, std::move(fitting), is_newest};
  }
  give(frame, recorded.world_from_camera, track.rest);
  (is_newest ? newest_ : earlier_) = track;
}

void Registration::learn() {
  if (!lesson_) return;
  std::optional<Track>& track = lesson_->is_newest ? newest_ : earlier_;
  Pose rest = track ? track->rest : Pose();  // none: time leapt
  add_keyframe(*lesson_, rest);
  if (track) track->rest = rest;
  status_.landmarks = landmarks_.size();
  lesson_.reset();
}

std::vector<Registration::Sighting> Registration::find_landmarks(const CameraFrame& frame, const cv::Mat& grey,
                                                                 const Track& track) {
  const Pose guess = frame.state.world_from_camera * common_.recorded_from_mounted * track.rest;
  const int radius = 2 * track.fitting < track.expected ? kWideRadius : kRadius;
  std::vector<Pose> camera_from_part;
  for (const Pose& pose : frame.state.world_from_part) camera_from_part.push_back(guess.inverse() * pose);
  std::vector<std::vector<std::size_t>> cells(kColumns * kRows);
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const glm::dvec3 at = camera_from_part[landmarks_[i].part] * landmarks_[i].point;
    if (at.z <= 0) continue;
    const glm::dvec2 pixel = frame.camera.pixel_from_camera(at);
    if (is_inside(pixel, grey, 0.5 * ExpectedLook::kSide + radius + 1)) {
      cells[static_cast<std::size_t>(cell_of(pixel, grey))].push_back(i);
    }
  }
  status_.expected = 0;
  std::vector<Sighting> sightings;
  for (std::vector<std::size_t>& cell : cells) {
    // Those that were found most dependably first.
    const auto dependability = [&](std::size_t i) {
      return static_cast<double>(landmarks_[i].found + 1) / static_cast<double>(landmarks_[i].tried + 2);
    };
    std::stable_sort(cell.begin(), cell.end(),
                     [&](std::size_t a, std::size_t b) { return dependability(a) > dependability(b); });
    std::size_t tried = 0;
    for (const std::size_t i : cell) {
      if (tried >= kPerCell) break;
      Landmark& landmark = landmarks_[i];
      const auto expected = expected_look(landmark, frame.camera, camera_from_part[landmark.part]);
      if (!expected) continue;
      const glm::dvec3 point = frame.state.world_from_part[landmark.part] * landmark.point;
      constexpr double kInFront = 0.98;  // of the distance: nothing may be nearer
      if (rays_->nearest(guess.translation, point - guess.translation, frame.state.world_from_part, kInFront)) continue;
      ++tried;
      ++landmark.tried;
      ++status_.expected;
      const auto found = find_look(*expected, grey, radius);
      if (!found || found->likeness < kLikeness) continue;
      sightings.push_back({i, point, found->pixel, glm::dvec2(frame.camera.ray_from_pixel(found->pixel))});
    }
  }
  return sightings;
}

Pose Registration::fit_picture(const CameraFrame& frame, const std::vector<Sighting>& sightings,
                               const Pose& last_rest) const {
  constexpr int kSteps = 10;
  const Pose mounted = frame.state.world_from_camera * common_.recorded_from_mounted;
  const glm::dvec2 focal = frame.camera.focal_length;
  Pose rest = last_rest;
  for (int step = 0; step < kSteps; ++step) {
    const Pose camera_from_world = (mounted * rest).inverse();
    std::vector<double> distances;
    for (const Sighting& sighting : sightings) {
      const glm::dvec3 p = camera_from_world * sighting.point_in_world;
      distances.push_back(p.z > 0 ? glm::length(focal * (sighting.ray - glm::dvec2(p) / p.z)) : 1e9);
    }
    const double reach = tukey_reach(distances);
    cv::Matx<double, 6, 6> normal = cv::Matx<double, 6, 6>::zeros();
    cv::Vec<double, 6> right = cv::Vec<double, 6>::all(0);
    for (std::size_t k = 0; k < sightings.size(); ++k) {
      if (!(distances[k] < reach)) continue;
      const glm::dvec3 p = camera_from_world * sightings[k].point_in_world;
      const glm::dvec2 at = glm::dvec2(p) / p.z, error = focal * (sightings[k].ray - at);
      const double share = 1 - distances[k] * distances[k] / (reach * reach);
      const double weight = share * share / (tolerances_.pixel * tolerances_.pixel);
      glm::dvec2 slope[6];
      for (int i = 0; i < 6; ++i) {
        glm::dvec3 axis(0);
        axis[i % 3] = 1;
        const glm::dvec3 moved = -(i < 3 ? axis : glm::cross(axis, p));
        slope[i] = focal * ((glm::dvec2(moved) - at * moved.z) / p.z);
      }
      for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 6; ++j) normal(i, j) += weight * glm::dot(slope[i], slope[j]);
        right[i] += weight * glm::dot(slope[i], error);
      }
    }
    const MotionVector whole = vector_of(rest), since = vector_of(last_rest.inverse() * rest);
    for (int i = 0; i < 6; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double tolerance = i < 3 ? tolerances_.rest_translation : tolerances_.rest_rotation;
      normal(i, i) += 1 / (tolerance * tolerance) + 1 / (kStep * kStep);
      right[i] -= whole[at] / (tolerance * tolerance) + since[at] / (kStep * kStep);
    }
    const cv::Vec<double, 6> solution = normal.solve(right, cv::DECOMP_CHOLESKY);
    MotionVector change{};
    for (int i = 0; i < 6; ++i) change[static_cast<std::size_t>(i)] = solution[i];
    rest = rest * motion_from(change);
    if (cv::norm(solution) < 1e-6) break;
  }
  return rest;
}

/// `rest`: of the picture; as it is found to be.
void Registration::add_keyframe(const Lesson& lesson, Pose& rest) {
  auto keyframe = std::make_shared<Keyframe>();
  ++keyframes_made_;
  for (const Pose& pose : lesson.recorded.world_from_part) {
    keyframe->part_from_recorded.push_back(pose.inverse() * lesson.recorded.world_from_camera);
  }
  keyframe->rest = rest;
  for (const Sighting& sighting : lesson.fitting) {
    Landmark& landmark = landmarks_[sighting.landmark];
    landmark.observations.push_back({keyframe, sighting.pixel});
    if (landmark.observations.size() > kObservations) landmark.observations.pop_front();
  }
  keyframes_.push_back(keyframe);
  if (keyframes_.size() > kWindow) keyframes_.pop_front();
  fit();
  rest = keyframe->rest;
  forget_landmarks();
  CameraFrame registered{{}, *camera_, lesson.recorded};
  registered.state.world_from_camera =
      lesson.recorded.world_from_camera * common_.recorded_from_mounted * keyframe->rest;
  add_landmarks(registered, lesson.grey, keyframe);
}

void Registration::fit() {
  std::size_t observations = 0;
  for (const Landmark& landmark : landmarks_) observations += landmark.observations.size();
  if (observations < kEnoughObservations || keyframes_made_ < kEnoughKeyframes) return;
  status_.error_recorded = error_of_record(*nominal_, landmarks_);
  const bool was_correcting = status_.is_correcting;
  status_.is_correcting = status_.error_recorded > (was_correcting ? kFitsAgain : kFitsNoMore);
  if (status_.is_correcting) {
    const std::vector<std::shared_ptr<Keyframe>> free(keyframes_.begin(), keyframes_.end());
    fit_registration(common_, *nominal_, landmarks_, free, tolerances_, was_correcting ? kFitSteps : kFirstFitSteps);
  } else if (was_correcting) {
    common_ = {};
    for (const auto& keyframe : keyframes_) keyframe->rest = {};
    for (auto* track : {&newest_, &earlier_}) {
      if (*track) (*track)->rest = {};
    }
  }
  camera_ = common_.camera(*nominal_);
}

void Registration::forget_landmarks() {
  std::erase_if(landmarks_, [](const Landmark& landmark) {
    return landmark.tried >= 10 && landmark.found * 10 < landmark.tried * 4;
  });
  if (landmarks_.size() <= kLandmarks) return;
  std::stable_sort(landmarks_.begin(), landmarks_.end(),
                   [](const Landmark& a, const Landmark& b) { return a.last_found > b.last_found; });
  landmarks_.resize(kLandmarks);
}

void Registration::add_landmarks(const CameraFrame& frame, const cv::Mat& grey,
                                 const std::shared_ptr<Keyframe>& keyframe) {
  constexpr int kCorners = 400;
  constexpr double kQuality = 0.005, kApart = 10;
  std::vector<std::size_t> counts(kColumns * kRows);
  std::vector<glm::dvec2> taken;
  const Pose camera_from_world = frame.state.world_from_camera.inverse();
  for (const Landmark& landmark : landmarks_) {
    const Pose camera_from_part = camera_from_world * frame.state.world_from_part[landmark.part];
    const glm::dvec3 at = camera_from_part * landmark.point;
    if (at.z <= 0) continue;
    const glm::dvec2 pixel = frame.camera.pixel_from_camera(at);
    if (!is_inside(pixel, grey, 0) || !expected_look(landmark, frame.camera, camera_from_part)) continue;
    taken.push_back(pixel);
    ++counts[static_cast<std::size_t>(cell_of(pixel, grey))];
  }
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, kCorners, kQuality, kApart);
  for (const cv::Point2f& corner : corners) {
    const glm::ivec2 place(static_cast<int>(corner.x), static_cast<int>(corner.y));
    const glm::dvec2 pixel = glm::dvec2(place) + 0.5;
    std::size_t& count = counts[static_cast<std::size_t>(cell_of(pixel, grey))];
    if (count >= kPerCell || !is_inside(pixel, grey, Landmark::kReach + 1)) continue;
    const auto is_near = [&](const glm::dvec2& other) { return glm::distance(other, pixel) < kApart; };
    if (std::any_of(taken.begin(), taken.end(), is_near)) continue;
    auto landmark = landmark_at(frame, grey, place, keyframe);
    if (!landmark || !place_landmark(*landmark, common_, *camera_)) continue;
    landmark->last_found = status_.pictures;
    landmarks_.push_back(std::move(*landmark));
    taken.push_back(pixel);
    ++count;
  }
}

std::optional<Landmark> Registration::landmark_at(const CameraFrame& frame, const cv::Mat& grey,
                                                  const glm::ivec2& place,
                                                  const std::shared_ptr<Keyframe>& keyframe) const {
  constexpr int kRing = 8;           // places around it ...
  constexpr double kAround = 8;      // ... pixels away
  constexpr double kFlat = 0.01;     // of the distance, off the plane
  constexpr double kGrazing = 0.25;  // cosine
  const glm::dvec2 pixel = glm::dvec2(place) + 0.5;
  const Pose& world_from_camera = frame.state.world_from_camera;
  struct Met {
    std::uint32_t part = 0;
    glm::dvec3 point{0};
  };
  const auto meet = [&](const glm::dvec2& at) -> std::optional<Met> {
    const glm::dvec3 ray = frame.camera.ray_from_pixel(at);
    const auto hit =
        rays_->nearest(world_from_camera.translation, world_from_camera.rotate(ray), frame.state.world_from_part, 1e9);
    if (!hit) return std::nullopt;
    return Met{model_->polygons()[hit->polygon].part, ray * hit->distance};
  };
  // Beside a silhouette, it would look different from elsewhere.
  const auto middle = meet(pixel);
  if (!middle) return std::nullopt;
  std::array<glm::dvec3, kRing> ring{};
  for (int i = 0; i < kRing; ++i) {
    const double angle = i * 2 * glm::pi<double>() / kRing;
    const auto met = meet(pixel + kAround * glm::dvec2(std::cos(angle), std::sin(angle)));
    if (!met || met->part != middle->part) return std::nullopt;
    ring[static_cast<std::size_t>(i)] = met->point;
  }
  glm::dvec3 area(0);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    area += glm::cross(ring[i] - middle->point, ring[(i + 1) % ring.size()] - middle->point);
  }
  if (!(glm::length(area) > 0)) return std::nullopt;
  const glm::dvec3 normal = glm::normalize(area);
  for (const glm::dvec3& point : ring) {
    if (!(std::abs(glm::dot(normal, point - middle->point)) < kFlat * middle->point.z)) return std::nullopt;
  }
  if (std::abs(glm::dot(normal, glm::normalize(middle->point))) < kGrazing) return std::nullopt;

  Landmark landmark;
  landmark.part = middle->part;
  const Pose part_from_camera = frame.state.world_from_part[middle->part].inverse() * world_from_camera;
  landmark.normal = part_from_camera.rotate(normal);
  landmark.offset = glm::dot(landmark.normal, part_from_camera * middle->point);
  landmark.anchor = keyframe;
  landmark.pixel = pixel;
  constexpr int kReach = Landmark::kReach;
  landmark.look = grey(cv::Rect(place.x - kReach, place.y - kReach, 2 * kReach + 1, 2 * kReach + 1)).clone();
  return landmark;
}

}  // namespace foreview
