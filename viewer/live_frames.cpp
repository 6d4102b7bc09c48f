#include "foreview/viewer/live_frames.h"

#include <algorithm>

#include "foreview/recordings/recording.h"

namespace foreview {

LiveFrames::LiveFrames(FrameSource& source, std::size_t camera, const Recording* recording,
                       const StalenessLimits& limits)
    : source_(source), camera_(camera), recording_(recording), limits_(limits) {}

void LiveFrames::take_delayed(const FrameMoment& moment) {
  // Other cameras' pictures give textures, too, but are not what is shown as delayed.
  const auto own = std::find_if(moment.pictures.begin(), moment.pictures.end(),
                                [&](const ShownPicture& picture) { return picture.record.camera == camera_; });
  if (own == moment.pictures.end()) {
    delayed_stamp_.reset();
    input_.delayed.picture.release();
    input_.capture.reset();
  } else if (delayed_stamp_ != own->record.captured) {
    delayed_stamp_ = own->record.captured;
    input_.delayed.picture = own->frame.picture;
    ++input_.delayed.key;
    input_.capture = own->frame.state;
  }
}

void LiveFrames::find_truth(Timestamp t, const ViewChoice& choice) {
  const bool from_there = choice.camera == CameraMode::follow && !choice.field_of_view;
  const auto nothing = [&] {
    input_.truth = {};
    reader_.reset();
  };
  if (recording_ == nullptr || choice.mode != ViewMode::difference || !from_there) return nothing();
  const std::optional<std::size_t> wanted = recording_->newest_before(camera_, t + Duration{1});
  if (!wanted) return nothing();
  if (!reader_) reader_ = std::make_unique<PictureReader>(*recording_, camera_);
  const auto read = reader_->wish(*wanted);
  if (!read) return;
  // The one read last is at most a few behind what is wished for, unless time was moved.
  const Timestamp stamp = recording_->cameras()[camera_].pictures[read->index].stamp;
  constexpr Duration kTooOld{500'000'000};
  if (read->index > *wanted || t - stamp > kTooOld) {
    input_.truth = {};
    return;
  }
  if (input_.truth.key != read->index + 1) input_.truth = {read->picture, read->index + 1};
  if (auto predicted = source_.predicted_state(stamp)) {
    input_.predicted = std::move(predicted);
    input_.moment = stamp;
  }
}

FrameInput& LiveFrames::at(Timestamp t, Timestamp since, const FrameMoment& moment, const ViewChoice& choice,
                           const std::function<Pose(const Pose&)>& operator_pose) {
  input_.moment = t;
  input_.predicted = source_.predicted_state(t);
  if (input_.predicted) input_.predicted->world_from_camera = operator_pose(input_.predicted->world_from_camera);
  input_.camera = source_.registered_camera();
  take_delayed(moment);
  find_truth(t, choice);
  StalenessInput known;
  known.now = t;
  known.since = since;
  const SourceStatus status = source_.status();
  known.expected_delay = status.expected_delay;
  if (source_.is_live()) {
    known.poses_expected = known.link_expected = true;
    if (input_.predicted) known.newest_pose = input_.predicted->stamp;
    known.last_heard = status.last_heard;
  }
  if (moment.newest != nullptr) known.newest_picture = moment.newest->record.captured;
  input_.staleness = assess_staleness(known, limits_);
  return input_;
}

}  // namespace foreview
