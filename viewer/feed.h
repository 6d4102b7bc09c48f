#pragma once
#include <optional>
#include <string>

#include "foreview/calib/registration.h"
#include "foreview/scene/camera_model.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/playback_clock.h"
#include "foreview/server/simulated_link.h"
#include "foreview/viewer/camera_surroundings.h"
#include "foreview/viewer/display_loop.h"
#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/viewer_status.h"

namespace foreview {

class Recording;

/// What a viewer shows: a model, and pictures and poses of it as they come in. A recording that is played
/// (RecordingFeed), or a live stream (LiveFeed).
class Feed {
 public:
  virtual ~Feed() = default;
  Feed() = default;
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  /// For the user, and for names of files.
  [[nodiscard]] virtual const std::string& name() const = 0;
  [[nodiscard]] virtual FrameSource& source() = 0;
  [[nodiscard]] virtual const PolygonModel& model() const = 0;
  /// How the model gets its textures, with these options of extraction in place of those given at first.
  [[nodiscard]] virtual LiveScene::Options scene_options(const ExtractionOptions& extraction) const = 0;

  /// Which of the source's cameras is the operator's.
  [[nodiscard]] virtual std::size_t camera() const = 0;
  /// That camera as it takes pictures (with its distortion). Live, a stand-in until it is heard of, and it may change.
  [[nodiscard]] virtual CameraModel camera_model() const = 0;
  [[nodiscard]] virtual bool camera_model_known() const { return true; }
  /// As known to begin with.
  [[nodiscard]] virtual CameraSurroundings surroundings() const = 0;

  /// How the operator's camera is being registered; none: it is not.
  [[nodiscard]] virtual std::optional<RegistrationStatus> registration() const { return std::nullopt; }

  /// Null where there is none: live.
  [[nodiscard]] virtual const Recording* recording() const { return nullptr; }
  /// Null where nobody can stop time: live.
  [[nodiscard]] virtual PlaybackClock* clock() { return nullptr; }
  /// The simulated link in front of the source.
  virtual void set_link(const LinkOptions& options) = 0;

  /// What is known of this feed alone, into the status.
  virtual void tell(ViewerStatus& /*status*/) {}
  /// As DisplayLoop::Callbacks::displayed.
  virtual void displayed(const PictureRecord& /*picture*/) {}
  /// A time of the source's in a file's name.
  [[nodiscard]] virtual std::string time_in_name(Timestamp t) const = 0;
};

}  // namespace foreview
