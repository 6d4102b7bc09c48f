#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "foreview/server/frame_source.h"
#include "foreview/viewer/display_loop.h"
#include "foreview/viewer/frame_input.h"
#include "foreview/viewer/picture_reader.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

class Recording;

/// What a frame of a DisplayLoop shows, for FrameComposer: gathered from the source and from what the loop says of the
/// newest textures. Waits for nothing.
class LiveFrames {
 public:
  /// `camera`: whose pictures are shown as the delayed ones. `recording`: where pictures of the moment itself are read
  /// for ViewMode::difference; null where nobody knows them. Both must outlive this.
  LiveFrames(FrameSource& source, std::size_t camera, const Recording* recording, const StalenessLimits& limits = {});

  /// Of display time `t`; `operator_pose` makes the operator's world_from_camera of where the real camera is then. In
  /// ViewMode::difference, seen from where the recorded camera was, the frame is that of the newest picture taken until
  /// then that could be read so far. `since`: when waiting for pictures began. Valid until the next call.
  [[nodiscard]] FrameInput& at(Timestamp t, Timestamp since, const FrameMoment& moment, const ViewChoice& choice,
                               const std::function<Pose(const Pose&)>& operator_pose);
  /// Whether the last frame had a truth to differ from.
  [[nodiscard]] bool truth_known() const { return !input_.truth.picture.empty(); }

 private:
  void take_delayed(const FrameMoment& moment);
  void find_truth(Timestamp t, const ViewChoice& choice);

  FrameSource& source_;
  std::size_t camera_;
  const Recording* recording_;
  StalenessLimits limits_;
  std::unique_ptr<PictureReader> reader_;
  std::optional<Timestamp> delayed_stamp_;
  FrameInput input_;
};

}  // namespace foreview
