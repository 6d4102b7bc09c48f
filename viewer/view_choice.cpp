#include "foreview/viewer/view_choice.h"

namespace foreview {
namespace {

template <class Values>
auto find_named(const Values& values, std::string_view text) -> std::optional<typename Values::value_type> {
  for (const auto value : values) {
    if (text == to_string(value)) return value;
  }
  return std::nullopt;
}

}  // namespace

const char* to_string(ViewMode mode) {
  switch (mode) {
    case ViewMode::predicted:
      return "predicted";
    case ViewMode::delayed:
      return "delayed";
    case ViewMode::side_by_side:
      return "both";
    case ViewMode::split:
      return "split";
    case ViewMode::difference:
      return "difference";
  }
  return "";
}

std::optional<ViewMode> parse_view_mode(std::string_view text) {
  return text == "side-by-side" ? ViewMode::side_by_side : find_named(kViewModes, text);
}

const char* to_string(ViewQuality quality) {
  return quality == ViewQuality::full ? "full" : "fast";
}

std::optional<ViewQuality> parse_view_quality(std::string_view text) {
  return find_named(kViewQualities, text);
}

const char* to_string(CameraMode mode) {
  switch (mode) {
    case CameraMode::follow:
      return "follow";
    case CameraMode::free:
      return "free";
    case CameraMode::look_around:
      return "look-around";
    case CameraMode::overview:
      return "overview";
  }
  return "";
}

std::optional<CameraMode> parse_camera_mode(std::string_view text) {
  return find_named(kCameraModes, text);
}

}  // namespace foreview
