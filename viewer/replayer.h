#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/recordings/recording.h"
#include "foreview/viewer/predicted_view.h"

namespace foreview {

/// What `replay` and `evaluate` have in common: everything that decides the predicted view of a recording.
struct ReplayOptions {
  std::filesystem::path recording;             ///< a directory, or the name of a built-in recording
  std::optional<std::filesystem::path> scene;  ///< instead of the recording's own model
  std::string camera;                          ///< whose pictures are compared and whose pose is the operator's
  Duration delay{500'000'000};
  std::string from, to;                ///< positions as Recording::parse_position; empty: all
  std::optional<std::size_t> history;  ///< only the last N pictures before t - delay
  ExtractionOptions extraction;
  std::optional<double> density;  ///< texels per metre; else the recording's proposal, else 500
  std::optional<int> max_texels;  ///< else the recording's proposal, else 256
  std::optional<std::filesystem::path> load_textures, save_textures;
};

/// A recording, its model and the textures that delayed pictures give it. Needs a current GL context (4.5, set up by
/// set_up_context_state()) in every member.
class Replayer {
 public:
  explicit Replayer(const ReplayOptions& options);
  ~Replayer();

  [[nodiscard]] Recording& recording();
  [[nodiscard]] const PolygonModel& model() const;
  [[nodiscard]] TextureStore& store();
  [[nodiscard]] PredictedView& view();
  [[nodiscard]] std::size_t camera() const;                  ///< index of the operator's camera
  [[nodiscard]] const CameraModel& operator_camera() const;  ///< undistorted model of that camera
  [[nodiscard]] Timestamp first() const;                     ///< of --from / --to, cut to where state is known
  [[nodiscard]] Timestamp last() const;

  /// Brings the textures to what an operator with this delay has at display time t: pictures of all cameras captured
  /// before t - delay (strictly), in capture order; with --history only each camera's last N. Going back in time, or
  /// with --history, starts afresh where it must. Damaged pictures are skipped and counted. Returns the pictures
  /// extracted by this call. `progress` (may be empty) is called per picture; it may throw Interrupted.
  std::size_t advance_to(Timestamp t, const std::function<void(std::size_t done, std::size_t todo)>& progress = {});
  /// M_d and P_d at t: the recorded state; none where nothing was recorded.
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp t) const;
  /// The newest picture used by the operator's camera so far, by index.
  [[nodiscard]] std::optional<std::size_t> newest_used() const;
  /// A picture of the operator's camera without lens distortion (CV_8UC3 BGR); InputError where it is damaged.
  [[nodiscard]] cv::Mat undistorted_picture(std::size_t index) const;
  /// Statistics summed over all pictures extracted so far.
  [[nodiscard]] const ExtractionStatistics& statistics() const;
  [[nodiscard]] std::size_t pictures_extracted() const;
  /// Writes --save-textures if asked for.
  void save_textures_if_asked() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
