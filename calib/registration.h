#pragma once
#include <cstddef>
#include <deque>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "foreview/calib/landmark.h"
#include "foreview/calib/registration_fit.h"
#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/scene/ray_caster.h"

namespace foreview {

/// How a camera's pictures are being registered. Medians are over the landmarks found in a picture, pixels.
struct RegistrationStatus {
  std::size_t pictures = 0;                          ///< taken in
  std::size_t searched = 0;                          ///< of them those in which landmarks were looked for
  std::size_t registered = 0;                        ///< of those the ones in which enough were found
  std::size_t landmarks = 0;                         ///< known now
  std::size_t expected = 0, found = 0, fitting = 0;  ///< of the one searched last: looked for, found, within 3 px
  double error_registered = 0;  ///< of the one searched last: how far from where they should be after correction
  double error_recorded = 0;    ///< how far those of the keyframes known are from where the record has them
  bool is_correcting = false;   ///< the record is off by more than a pixel, else it stays as it is
};

/// Corrects the registration of one camera's pictures, instead of discarding its errors (spec 14): its poses are off
/// (hand-eye calibration, encoders, tracking), and its nominal focal length and principal point too. Landmarks (corners
/// in pictures, on the model's surface) are found again in later pictures; what is the same in all pictures and what
/// each picture is off by itself is put so that they fit best: bundle adjustment over the last keyframes, with the
/// landmarks held to the model's surface.
///
/// Where the record fits the pictures within a pixel nothing is corrected: landmarks' noise would only do harm; nor in
/// the first hundred pictures, from which what is constant is found badly. Else,
/// only pictures given earlier decide; nothing is undone: textures stay where earlier corrections put them. Where there
/// is too little to recognise, the last correction stays. What moves and is not known to move (no part of the model)
/// is outvoted or, where it fills the picture, followed as far as the tolerances allow.
class Registration {
 public:
  /// Both must outlive it.
  Registration(const PolygonModel& model, const RayCaster& rays, const RegistrationTolerances& tolerances = {});

  /// Corrects the frame's pose and camera by what it and frames before it teach: place() and learn(), and once more
  /// where that taught something.
  void correct(CameraFrame& frame);
  /// Corrects the frame's pose and camera by what frames before it taught. Frames in the order they are extracted;
  /// those captured before others that were given already (late ones, history) do not disturb what later ones are
  /// corrected by. Another camera model (size, lens) than the last one's begins afresh. Some milliseconds on the CPU;
  /// next to nothing, three times out of four, where the record was found to fit.
  void place(CameraFrame& frame);
  /// Learns from the frame placed last, for later ones: now and then it takes longer than place(), some tens of
  /// milliseconds.
  void learn();
  /// Time leaps, also back: what single pictures are off by is found anew; what all have in common stays.
  void leap();

  /// What the last picture's pose was corrected by, in the world: registered_from_recorded() * world_from_camera. A
  /// recorded pose of a later moment so corrected is where the record says that the camera has gone since, from where
  /// the last picture was found to be. Identity where nothing is corrected.
  [[nodiscard]] const Pose& registered_from_recorded() const { return registered_from_recorded_; }
  /// The camera as the last picture was given it; none before the first.
  [[nodiscard]] const std::optional<CameraModel>& camera() const { return given_camera_; }
  [[nodiscard]] const RegistrationStatus& status() const { return status_; }

 private:
  struct Sighting {
    std::size_t landmark = 0;
    glm::dvec3 point_in_world{0};
    glm::dvec2 pixel{0}, ray{0};
  };
  /// Where a sequence of pictures has got to: those that come in the order of capture, or those before them.
  struct Track {
    Timestamp stamp;  ///< of its last picture
    Pose rest;
    std::size_t expected = 0, fitting = 0;  ///< landmarks
  };
  /// What is to be learnt from a picture.
  struct Lesson {
    CaptureState recorded;
    cv::Mat grey;
    std::vector<Sighting> fitting;
    bool is_newest = true;
  };
  [[nodiscard]] Track nearest_track(Timestamp stamp) const;
  [[nodiscard]] std::vector<Sighting> find_landmarks(const CameraFrame& frame, const cv::Mat& grey, const Track& track);
  [[nodiscard]] Pose fit_picture(const CameraFrame& frame, const std::vector<Sighting>& sightings,
                                 const Pose& last_rest) const;
  void give(CameraFrame& frame, const Pose& recorded, const Pose& rest);
  void fit();
  void add_keyframe(const Lesson& lesson, Pose& rest);
  void add_landmarks(const CameraFrame& frame, const cv::Mat& grey, const std::shared_ptr<Keyframe>& keyframe);
  [[nodiscard]] std::optional<Landmark> landmark_at(const CameraFrame& frame, const cv::Mat& grey,
                                                    const glm::ivec2& pixel,
                                                    const std::shared_ptr<Keyframe>& keyframe) const;
  void forget_landmarks();

  const PolygonModel* model_;
  const RayCaster* rays_;
  RegistrationTolerances tolerances_;
  std::optional<CameraModel> nominal_, camera_, given_camera_;
  CameraRegistration common_;
  std::optional<Track> newest_, earlier_;
  std::optional<Lesson> lesson_;
  Pose registered_from_recorded_;
  std::vector<Landmark> landmarks_;
  std::deque<std::shared_ptr<Keyframe>> keyframes_;  ///< whose rests are still fitted
  std::size_t keyframes_made_ = 0;
  RegistrationStatus status_;
};

}  // namespace foreview
