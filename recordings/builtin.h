#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// Errors of spec 5, put into what the recording *says*, not into its pictures.
struct InjectedErrors {
  double pose_degrees = 0;      ///< the pan axis's zero: every camera turned about the world's vertical through itself
  double pose_millimetres = 0;  ///< translation of every camera pose along a fixed oblique direction of the camera
  double focal_length_percent = 0;
  double distortion_percent = 0;  ///< all coefficients too large by this
  double model_millimetres = 0;   ///< every movable and free-standing object of the model displaced by this
  bool operator==(const InjectedErrors&) const = default;
};

struct GenerateOptions {
  std::string name;                     ///< "workcell", "object" or "cube"
  std::optional<std::size_t> pictures;  ///< only the first N instants (per camera); none: all
  std::size_t first_picture = 0;        ///< begin here: instants keep their numbers, stamps and contents
  double scale = 1.0;                   ///< of the picture size (tests use small pictures)
  InjectedErrors errors;
  bool operator==(const GenerateOptions&) const = default;
};

/// Names of the built-in recordings:
/// "workcell": a closed room with a seven-joint arm that lifts a workpiece, seen by the stereo pair "left", "right" on
///   a pan-tilt head; 1,936 polygons, 320 instants at 25 Hz.
/// "object": a free-standing thing of 139 polygons in a hall; the camera swings through a third of the way around, so
///   that the textures stay partly empty (spec 12's "partly textured object"). The hall belongs to the backdrop.
/// "cube": six polygons, each seen almost wholly.
[[nodiscard]] std::vector<std::string> builtin_recording_names();
/// Generates into `directory` (created; must not hold another recording). Deterministic: same options, same bytes.
/// `progress(done, todo)` may throw Interrupted: then the directory is left marked incomplete and is resumed or redone.
void generate_recording(const GenerateOptions& options, const std::filesystem::path& directory,
                        const std::function<void(std::size_t, std::size_t)>& progress = {});
/// Where built-in recordings are cached: $FOREVIEW_CACHE, else $XDG_CACHE_HOME/foreview, else ~/.cache/foreview.
[[nodiscard]] std::filesystem::path recording_cache_directory();
/// The cached recording of these options, generated first if it is not there whole (a version and the options are part
/// of the directory's name).
[[nodiscard]] std::filesystem::path cached_recording(
    const GenerateOptions& options, const std::function<void(std::size_t, std::size_t)>& progress = {});

/// The synthetic site itself: truth for any time and viewpoint.
class SyntheticSite {
 public:
  explicit SyntheticSite(const std::string& name);
  ~SyntheticSite();
  SyntheticSite(const SyntheticSite&) = delete;
  SyntheticSite& operator=(const SyntheticSite&) = delete;
  /// The exact model, parts named; what generate_recording() writes as scene.obj (before injected errors).
  [[nodiscard]] const RawMesh& mesh() const;
  [[nodiscard]] std::size_t instants() const;  ///< 320 for workcell
  [[nodiscard]] Timestamp stamp(std::size_t instant) const;
  [[nodiscard]] std::size_t camera_count() const;
  [[nodiscard]] const CameraModel& camera(std::size_t index) const;
  [[nodiscard]] Pose world_from_camera(std::size_t camera, Timestamp stamp) const;
  /// Poses of mesh().part_names, same order.
  [[nodiscard]] std::vector<Pose> world_from_part(Timestamp stamp) const;
  /// What a camera (with its distortion) at this pose sees at this time, without sensor noise; CV_8UC3 BGR.
  [[nodiscard]] cv::Mat render(const CameraModel& camera, const Pose& world_from_camera, Timestamp stamp) const;
  /// Faces of mesh() that such a picture shows: front faces that own at least one of its samples; ascending.
  [[nodiscard]] std::vector<std::uint32_t> visible_polygons(const CameraModel& camera, const Pose& world_from_camera,
                                                            Timestamp stamp) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
