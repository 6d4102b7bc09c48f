#include "foreview/recordings/recording.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cassert>
#include <charconv>

#include "foreview/recordings/picture_file.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

bool earlier(const Recording::PictureEntry& picture, Timestamp stamp) {
  return picture.stamp < stamp;
}

}  // namespace

std::size_t Recording::camera_index(const std::string& name) const {
  if (name.empty()) return 0;
  std::string names;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].name == name) return i;
    names += (names.empty() ? "" : ", ") + cameras_[i].name;
  }
  throw InputError("camera " + in_quotes(name), "is not in the recording; there are: " + names);
}

Timestamp Recording::first_stamp(std::size_t camera) const {
  return cameras_.at(camera).pictures.front().stamp;
}

Timestamp Recording::last_stamp(std::size_t camera) const {
  return cameras_.at(camera).pictures.back().stamp;
}

Timestamp Recording::parse_position(std::string_view text, const std::string& option, std::size_t camera) const {
  const std::vector<PictureEntry>& pictures = cameras_.at(camera).pictures;
  if (text.starts_with('#')) {
    std::size_t index = 0;
    const char* const stop = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data() + 1, stop, index);
    if (error != std::errc() || end != stop || index >= pictures.size()) {
      throw InputError(option, in_quotes(text) + " is no picture of the recording; expected #0 to #" +
                                   std::to_string(pictures.size() - 1));
    }
    return pictures[index].stamp;
  }
  const Duration since_start = Duration::parse(text, option);
  constexpr double kLongest = 1e9;  // seconds; the sum with any stamp of a recording stays within 64 bits
  if (since_start.nanoseconds < 0 || since_start.seconds() > kLongest) {
    throw InputError(option, in_quotes(text) + " is no time since the recording's start; it lasts " +
                                 number_text((last_stamp(camera) - first_stamp(camera)).seconds()) + " s");
  }
  return first_stamp(camera) + since_start;
}

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

cv::Mat Recording::read_picture(std::size_t camera, std::size_t index) const {
  const Camera& source = cameras_.at(camera);
  const std::filesystem::path& file = source.pictures.at(index).file;
  const std::string bytes = read_input_file(file, kMostPictureBytes);
  return decode_picture({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, file.string(),
                        cv::Size(source.model.width, source.model.height));
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

std::optional<std::size_t> Recording::newest_before(std::size_t camera, Timestamp before) const {
  const std::vector<PictureEntry>& pictures = cameras_.at(camera).pictures;
  const auto next = std::lower_bound(pictures.begin(), pictures.end(), before, earlier);
  if (next == pictures.begin()) return std::nullopt;
  return static_cast<std::size_t>(next - pictures.begin()) - 1;
}

}  // namespace foreview
