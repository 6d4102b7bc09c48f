#include "foreview/viewer/replay_frames.h"

#include <spdlog/spdlog.h>

#include "foreview/scene/errors.h"

namespace foreview {

ReplayFrames::ReplayFrames(Replayer& replayer, Duration delay, const StalenessLimits& limits)
    : replayer_(replayer), delay_(delay), limits_(limits) {
  const Recording::Camera& camera = replayer.recording().cameras()[replayer.camera()];
  std::vector<Pose> cameras;
  for (const auto& sample : camera.world_from_camera.samples()) cameras.push_back(sample.pose);
  const auto state = replayer.predicted_state(replayer.first());
  const std::vector<Pose> parts = state ? state->world_from_part : std::vector<Pose>(replayer.model().parts().size());
  camera_.set_surroundings(find_surroundings(replayer.model(), parts, cameras));
}

void ReplayFrames::read(FramePicture& picture, std::optional<std::size_t> index) const {
  const std::uint64_t key = index ? *index + 1 : 0;
  if (key == picture.key) return;
  picture.key = key;
  picture.picture.release();
  if (!index) return;
  try {
    picture.picture = replayer_.recording().read_picture(replayer_.camera(), *index);
  } catch (const InputError& error) {
    spdlog::warn("{}", error.what());
  }
}

void ReplayFrames::set_pictures(Timestamp t, const ViewChoice& choice) {
  Recording& recording = replayer_.recording();
  const std::size_t camera = replayer_.camera();
  const std::optional<std::size_t> newest = replayer_.newest_used();
  if (shows_delayed(choice.mode)) read(input_.delayed, newest);
  input_.capture.reset();
  if (const auto& used = replayer_.last_used_by_operator()) input_.capture = used->state;
  const bool from_there = choice.camera == CameraMode::follow && !choice.field_of_view;
  if (choice.mode != ViewMode::difference || !from_there) return read(input_.truth, std::nullopt);
  // Between two pictures: what the earlier one shows, with the prediction of its own moment.
  const std::optional<std::size_t> truth = recording.newest_before(camera, t + Duration{1});
  read(input_.truth, truth);
  if (truth) input_.predicted = replayer_.predicted_state(recording.cameras()[camera].pictures[*truth].stamp);
}

FrameInput& ReplayFrames::at(Timestamp t, const ViewChoice& choice) {
  input_.moment = t;
  input_.predicted = replayer_.predicted_state(t);
  input_.camera = replayer_.registered_camera();
  set_pictures(t, choice);
  if (input_.predicted) {
    camera_.apply(choice, replayer_.operator_camera(), input_.predicted->world_from_camera);
    input_.predicted->world_from_camera = camera_.pose();
  }
  StalenessInput known;
  known.now = t;
  known.since = replayer_.first();
  known.expected_delay = delay_;
  if (const auto used = replayer_.last_used()) {
    known.newest_picture = replayer_.recording().cameras()[used->camera].pictures[used->index].stamp;
  }
  input_.staleness = assess_staleness(known, limits_);
  return input_;
}

}  // namespace foreview
