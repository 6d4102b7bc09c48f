#pragma once
#include <cstddef>
#include <optional>

#include "foreview/viewer/frame_input.h"
#include "foreview/viewer/operator_camera.h"
#include "foreview/viewer/replayer.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// What a frame of a replay shows, for FrameComposer: gathered from the recording and from what the Replayer has used.
class ReplayFrames {
 public:
  /// `delay` is what pictures are late by when all is well. The replayer must outlive this.
  ReplayFrames(Replayer& replayer, Duration delay, const StalenessLimits& limits = {});

  /// Of display time t: call Replayer::advance_to(t) before. Pictures are read only where the choice shows them. The
  /// operator's camera is where the choice says, without transitions. What the recording does not know at t is left
  /// out; a picture that cannot be read (any more), too. Valid until the next call.
  [[nodiscard]] FrameInput& at(Timestamp t, const ViewChoice& choice);

 private:
  void set_pictures(Timestamp t, const ViewChoice& choice);
  void read(FramePicture& picture, std::optional<std::size_t> index) const;

  Replayer& replayer_;
  Duration delay_;
  StalenessLimits limits_;
  OperatorCamera camera_;
  FrameInput input_;
};

}  // namespace foreview
