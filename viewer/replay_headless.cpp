#include <spdlog/spdlog.h>

#include <cstdio>
#include <optional>
#include <string>

#include "foreview/scene/errors.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/picture_output.h"
#include "foreview/viewer/progress.h"
#include "foreview/viewer/replay_frames.h"
#include "foreview/viewer/replay_session.h"

namespace foreview {

std::vector<ReplayInstant> replay_instants(Replayer& replayer) {
  std::vector<ReplayInstant> instants;
  const auto& pictures = replayer.recording().cameras()[replayer.camera()].pictures;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].stamp < replayer.first() || pictures[i].stamp > replayer.last()) continue;
    instants.push_back({i, pictures[i].stamp});
  }
  return instants;
}

namespace {

/// Extracts what is due at the first instant: that can be hundreds of pictures.
void catch_up(Replayer& replayer, Timestamp t) {
  std::optional<ProgressBar> progress;
  replayer.advance_to(t, [&](std::size_t done, std::size_t todo) {
    throw_if_interrupted();
    if (!progress) progress.emplace("textures", todo);
    progress->update(done);
  });
}

}  // namespace

ReplaySummary replay_headless(Replayer& replayer, const ReplaySessionOptions& options) {
  const std::vector<ReplayInstant> instants = replay_instants(replayer);
  const auto& pictures = replayer.recording().cameras()[replayer.camera()].pictures;
  const std::filesystem::path directory = options.out / to_string(options.choice.mode);
  const Recording::Camera& camera = replayer.recording().cameras()[replayer.camera()];
  FrameComposer composer(replayer.view(), camera.model, options.near_plane);
  ReplayFrames frames(replayer, options.delay);
  ReplaySummary summary;
  const auto write_frame = [&](Timestamp t, const std::string& stem) {
    composer.compose(frames.at(t, options.choice), options.choice, composer.native_size(options.choice.mode));
    write_png(directory / (stem + ".png"), composer.read());
    ++summary.pictures_written;
  };
  if (!options.at.empty()) {
    const Timestamp t = replayer.recording().parse_position(options.at, "--at", replayer.camera());
    if (!replayer.predicted_state(t)) {
      throw InputError("--at", "nothing was recorded at " + options.at + "; expected a time within the recording");
    }
    catch_up(replayer, t);
    char stem[40];
    std::snprintf(stem, sizeof stem, "at-%.3fs", (t - replayer.recording().first_stamp(replayer.camera())).seconds());
    write_frame(t, stem);
    return summary;
  }
  if (!instants.empty()) catch_up(replayer, instants.front().stamp);
  ProgressBar progress("replay", instants.size());
  for (std::size_t i = 0; i < instants.size(); i += options.every) {
    throw_if_interrupted();
    const Timestamp t = instants[i].stamp;
    replayer.advance_to(t, [](std::size_t, std::size_t) { throw_if_interrupted(); });
    if (!replayer.predicted_state(t)) {
      spdlog::debug("{}: no recorded state, skipped", pictures[instants[i].index].stem);
      ++summary.instants_without_state;
      continue;
    }
    write_frame(t, pictures[instants[i].index].stem);
    progress.update(i + 1);
  }
  return summary;
}

}  // namespace foreview
