#include <spdlog/spdlog.h>

#include <utility>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"

namespace foreview {

std::optional<CaptureState> Recording::capture_state(std::size_t camera, Timestamp stamp,
                                                     const PolygonModel& model) const {
  const std::optional<Pose> world_from_camera = cameras_.at(camera).world_from_camera.at(stamp);
  if (!world_from_camera) return std::nullopt;
  CaptureState state;
  state.stamp = stamp;
  state.world_from_camera = *world_from_camera;
  state.world_from_part.assign(model.parts().size(), Pose());
  for (const auto& [name, trajectory] : parts_) {
    const int part = model.part_index(name);
    if (part < 0) continue;
    const std::optional<Pose> pose = trajectory.size() == 1 ? trajectory.samples().front().pose : trajectory.at(stamp);
    if (!pose) return std::nullopt;
    state.world_from_part[static_cast<std::size_t>(part)] = *pose;
  }
  return state;
}

std::optional<PredictedState> Recording::predicted_state(std::size_t camera, Timestamp stamp,
                                                         const PolygonModel& model) const {
  std::optional<CaptureState> state = capture_state(camera, stamp, model);
  if (!state) return std::nullopt;
  return PredictedState{state->stamp, state->world_from_camera, std::move(state->world_from_part)};
}

std::optional<CameraFrame> Recording::read_frame(std::size_t camera, std::size_t index, const PolygonModel& model) {
  const Camera& source = cameras_.at(camera);
  const PictureEntry& entry = source.pictures.at(index);
  const auto drop = [&](std::size_t& count, const std::string& why) {
    if (!dropped_.insert({camera, index}).second) return;
    // One line per kind; the rest only where someone asks for every detail.
    const auto level = count++ == 0 ? spdlog::level::warn : spdlog::level::debug;
    spdlog::log(level, "{}: picture dropped: {}", name_, why);
  };
  std::optional<CaptureState> state = capture_state(camera, entry.stamp, model);
  if (!state) {
    drop(damage_.pictures_without_pose, entry.file.string() + ": taken outside the recorded time of a part");
    return std::nullopt;
  }
  try {
    return CameraFrame{read_picture(camera, index), source.model, std::move(*state)};
  } catch (const InputError& error) {
    drop(damage_.pictures_unreadable, error.what());
    return std::nullopt;
  }
}

}  // namespace foreview
