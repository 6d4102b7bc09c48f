#include "foreview/recordings/recording.h"

#include <algorithm>
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

cv::Mat Recording::read_picture(std::size_t camera, std::size_t index) const {
  const Camera& source = cameras_.at(camera);
  const std::filesystem::path& file = source.pictures.at(index).file;
  const std::string bytes = read_input_file(file, kMostPictureBytes);
  return decode_picture({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, file.string(),
                        cv::Size(source.model.width, source.model.height));
}

std::optional<std::size_t> Recording::newest_before(std::size_t camera, Timestamp before) const {
  const std::vector<PictureEntry>& pictures = cameras_.at(camera).pictures;
  const auto next = std::lower_bound(pictures.begin(), pictures.end(), before, earlier);
  if (next == pictures.begin()) return std::nullopt;
  return static_cast<std::size_t>(next - pictures.begin()) - 1;
}

}  // namespace foreview
