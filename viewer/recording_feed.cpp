#include "foreview/viewer/recording_feed.h"

#include <algorithm>
#include <vector>

#include "foreview/viewer/formatted.h"

namespace foreview {
namespace {

PlaybackClock::Options clock_options(const RecordingFeed::Options& options, const ReplaySpan& span) {
  PlaybackClock::Options result;
  result.first = span.first;
  result.last = span.last;
  result.speed = options.speed;
  result.loop = options.loop;
  result.playing = false;  // until there is something to see
  return result;
}

RecordingPlayer::Options player_options(const RecordingFeed::Options& options, const ReplayInput& input) {
  RecordingPlayer::Options result;
  result.link = options.link;
  result.camera = input.camera;
  std::size_t most = 0;
  for (const Recording::Camera& camera : input.recording.cameras()) most = std::max(most, camera.pictures.size());
  result.history = options.replay.history ? *options.replay.history - 1 : most;
  return result;
}

}  // namespace

RecordingFeed::RecordingFeed(const Options& options)
    : input_(options.replay),
      span_(find_span(input_)),
      clock_(clock_options(options, span_)),
      player_(input_.recording, input_.model, clock_, player_options(options, input_)) {
  if (options.replay.registration) registered_.emplace(player_, input_.model, input_.camera);
}

FrameSource& RecordingFeed::source() {
  if (registered_) return *registered_;
  return player_;
}

std::optional<RegistrationStatus> RecordingFeed::registration() const {
  return registered_ ? std::optional(registered_->registration()) : std::nullopt;
}

LiveScene::Options RecordingFeed::scene_options(const ExtractionOptions& extraction) const {
  LiveScene::Options options = live_scene_options(input_.options, input_.charts, input_.recording.initial_textures());
  options.extraction = extraction;
  return options;
}

CameraModel RecordingFeed::camera_model() const {
  return input_.recording.cameras()[input_.camera].model;
}

CameraSurroundings RecordingFeed::surroundings() const {
  std::vector<Pose> cameras;
  for (const auto& sample : input_.recording.cameras()[input_.camera].world_from_camera.samples()) {
    cameras.push_back(sample.pose);
  }
  const auto state = player_.predicted_state(span_.first);
  const std::vector<Pose> parts = state ? state->world_from_part : std::vector<Pose>(input_.model.parts().size());
  return find_surroundings(input_.model, parts, cameras);
}

void RecordingFeed::tell(ViewerStatus& status) {
  status.first = span_.first;
  status.last = span_.last;
}

std::string RecordingFeed::time_in_name(Timestamp t) const {
  return formatted("%.3fs", (t - input_.recording.first_stamp(input_.camera)).seconds());
}

}  // namespace foreview
