#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "foreview/calib/registration.h"
#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/recordings/recording.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/run_counters.h"

namespace foreview {

/// What `replay` and `evaluate` have in common: everything that decides the predicted view of a recording.
struct ReplayOptions {
  std::filesystem::path recording;             ///< a directory, or the name of a built-in recording
  std::optional<std::filesystem::path> scene;  ///< instead of the recording's own model
  std::string camera;                          ///< whose pictures are compared and whose pose is the operator's
  Duration delay{500'000'000};
  std::string from, to;                ///< positions as Recording::parse_position; empty: all
  std::optional<std::size_t> history;  ///< only the last N pictures before t - delay
  PipelineKind pipeline = PipelineKind::batched;
  ExtractionOptions extraction{.compensate_exposure = true};
  bool registration = true;       ///< correct poses and cameras by what pictures show (Registration)
  std::optional<double> density;  ///< texels per metre; else the recording's proposal, else propose_textures()
  std::optional<int> max_texels;  ///< else the recording's proposal, else propose_textures()
  std::optional<std::filesystem::path> load_textures, save_textures;
  bool stats = false;  ///< count the texels that took a colour, too, which costs a read-back per picture
};

/// A recording, its model and the textures that delayed pictures give it. Needs a current GL context (4.5, set up by
/// set_up_context_state()) in every member.
class Replayer {
 public:
  /// Opens the recording (a directory wins over a built-in one of the same name, which is generated first where it is
  /// not cached, with a progress bar), imports the model and allocates the textures. Throws InputError where the
  /// recording, its model or the options cannot be used, or no picture lies within from..to.
  explicit Replayer(const ReplayOptions& options);
  ~Replayer();

  [[nodiscard]] Recording& recording();
  [[nodiscard]] const PolygonModel& model() const;
  [[nodiscard]] TextureStore& store();
  [[nodiscard]] PredictedView& view();
  [[nodiscard]] std::size_t camera() const;                  ///< index of the operator's camera
  [[nodiscard]] const CameraModel& operator_camera() const;  ///< undistorted model of that camera
  [[nodiscard]] const ChartOptions& chart_options() const;   ///< density and largest size of the textures
  [[nodiscard]] Timestamp first() const;                     ///< of --from / --to, cut to where state is known
  [[nodiscard]] Timestamp last() const;

  /// Brings the textures to what an operator with this delay has at display time t: pictures of all cameras captured
  /// before t - delay (strictly), in capture order; with --history only each camera's last N. Going back in time, or
  /// with --history, starts afresh where it must: what the textures hold depends on t alone, not on earlier calls.
  /// Damaged pictures are skipped and counted, and do not count for --history. Returns the pictures extracted by this
  /// call. `progress` (may be empty) is called per picture; it may throw Interrupted.
  std::size_t advance_to(Timestamp t, const std::function<void(std::size_t done, std::size_t todo)>& progress = {});
  /// M_d and P_d at t: the recorded state; none where nothing was recorded. With registration, the operator's camera is
  /// where the pictures used so far make it out to be.
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp t) const;
  /// The newest picture used by the operator's camera so far, by index.
  [[nodiscard]] std::optional<std::size_t> newest_used() const;
  /// operator_camera(), with registration as the pictures used so far correct it: where predictions are to fall on
  /// the true picture.
  [[nodiscard]] CameraModel registered_camera() const;
  struct UsedPicture {
    std::size_t camera = 0, index = 0;
    CameraModel model;   ///< that it was extracted with, undistorted: with registration, the corrected one ...
    CaptureState state;  ///< ... and so its pose
  };
  /// The newest picture used of any camera: the one whose colours win.
  [[nodiscard]] const std::optional<UsedPicture>& last_used() const;
  /// The newest one used of the operator's camera.
  [[nodiscard]] const std::optional<UsedPicture>& last_used_by_operator() const;
  /// How the operator's camera is being registered; none without registration.
  [[nodiscard]] std::optional<RegistrationStatus> registration() const;
  /// A picture of the operator's camera without lens distortion (CV_8UC3 BGR); InputError where it is damaged.
  [[nodiscard]] cv::Mat undistorted_picture(std::size_t index) const;
  /// CV_8U, 255 where an undistorted picture has content; all of it, but for lenses that see less than their
  /// undistorted picture would show.
  [[nodiscard]] const cv::Mat& usable_pixels() const;
  /// Statistics summed over all pictures extracted so far.
  [[nodiscard]] const ExtractionStatistics& statistics() const;
  [[nodiscard]] std::size_t pictures_extracted() const;
  [[nodiscard]] std::size_t pictures_damaged() const;  ///< found unreadable so far
  /// What --stats prints: statistics() and what else was counted.
  [[nodiscard]] RunCounters counters() const;
  [[nodiscard]] double extraction_seconds() const;  ///< wall clock, reading and decoding of pictures not included
  /// Writes --save-textures if asked for.
  void save_textures_if_asked() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
