#pragma once
#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "foreview/scene/pose.h"

namespace foreview {

enum class ViewMode {
  predicted,
  delayed,       ///< the newest picture, as it came, without lens distortion
  side_by_side,  ///< predicted at the left of delayed; "both" for --view
  split,         ///< predicted left of a line, delayed right of it, both over the whole frame
  difference,    ///< between the predicted view and the picture taken at that very moment, where there is one
};
inline constexpr std::array kViewModes{ViewMode::predicted, ViewMode::delayed, ViewMode::side_by_side, ViewMode::split,
                                       ViewMode::difference};
/// As --view takes it.
[[nodiscard]] const char* to_string(ViewMode mode);
/// Also "side-by-side". None where the text is no mode's name.
[[nodiscard]] std::optional<ViewMode> parse_view_mode(std::string_view text);
[[nodiscard]] constexpr bool shows_predicted(ViewMode mode) {
  return mode != ViewMode::delayed;
}
[[nodiscard]] constexpr bool shows_delayed(ViewMode mode) {
  return mode == ViewMode::delayed || mode == ViewMode::side_by_side || mode == ViewMode::split;
}

/// What a frame may cost.
enum class ViewQuality {
  full,  ///< four samples a pixel, textures filtered as well as is worth while
  fast,  ///< one sample a pixel, less filtering: for software rendering, where that takes a fifth of the time
};
inline constexpr std::array kViewQualities{ViewQuality::full, ViewQuality::fast};
/// As --quality takes it.
[[nodiscard]] const char* to_string(ViewQuality quality);
[[nodiscard]] std::optional<ViewQuality> parse_view_quality(std::string_view text);

/// Where the operator's camera is (OperatorCamera).
enum class CameraMode {
  follow,       ///< where the recording's camera was
  free,         ///< anywhere: orbit, pan, dolly, fly, look
  look_around,  ///< at the recorded position, turned by the operator
  overview,     ///< spatial prediction (spec 13.3): from above and behind, so that the real camera's view is seen
};
inline constexpr std::array kCameraModes{CameraMode::follow, CameraMode::free, CameraMode::look_around,
                                         CameraMode::overview};
/// As --camera-mode takes it.
[[nodiscard]] const char* to_string(CameraMode mode);
[[nodiscard]] std::optional<CameraMode> parse_camera_mode(std::string_view text);

/// What is drawn over the views. Any of them together; over the predicted view where not said otherwise.
struct Overlays {
  bool holes = false;       ///< in pink: filled texels, and polygons that no picture has shown
  bool never_seen = false;  ///< hatched: polygons that no picture has shown
  bool age = false;         ///< heat map: seconds since the picture was taken that a colour is from
  bool density = false;     ///< heat map: how many pixels of the frame a texel covers
  bool wireframe = false;   ///< edges of polygons
  bool edges = false;       ///< edges of polygons over the delayed picture, where its camera was
  bool cone = false;        ///< lights what the newest picture's camera saw, and draws its frustum (spec 13)
  bool operator==(const Overlays&) const = default;
  /// Whether any of those is on that colour surfaces.
  [[nodiscard]] bool colours_surfaces() const { return holes || never_seen || age || density || cone; }
};

/// What is drawn of a display instant, and from where: with the textures and the poses of that instant, all that a
/// frame depends on. Pure state, without clock, window or GL; view_options_cli.h turns it into options and back.
struct ViewChoice {
  ViewMode mode = ViewMode::predicted;
  ViewQuality quality = ViewQuality::full;
  double split = 0.5;  ///< where the line is, 0 (left) to 1 (right)
  Overlays overlays;
  double age_span = 10;                  ///< seconds at the upper end of the scale of ages
  std::optional<std::uint32_t> polygon;  ///< highlighted with its chart (the one under the cursor)

  CameraMode camera = CameraMode::follow;
  std::optional<Pose> pose;             ///< free, overview: world_from_camera; none: where the mode begins
  glm::dvec2 turn{0, 0};                ///< look_around: radians to the right, down, from the recorded rotation
  std::optional<double> field_of_view;  ///< radians, from the frame's top to its bottom; none: the camera's own
  bool operator==(const ViewChoice&) const = default;
};

inline constexpr double kLeastFieldOfView = 0.01, kGreatestFieldOfView = 2.8;  ///< radians

}  // namespace foreview
