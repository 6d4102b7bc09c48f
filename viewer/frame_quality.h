#pragma once
#include <functional>
#include <string_view>

#include "foreview/scene/timestamp.h"
#include "foreview/viewer/loop_platform.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// What frames may be drawn with, so that they come steadily and leave extraction its time: full where such a frame
/// takes no more than this part of a period, else fast.
inline constexpr double kFullQualityPart = 0.4;
[[nodiscard]] ViewQuality quality_that_fits(Duration full_frame, Duration period);

/// Whether a GL renderer of this name (GL_RENDERER) is the CPU.
[[nodiscard]] bool is_software_renderer(std::string_view renderer);

/// What a frame takes: the median of a few that are drawn now, after one that is not counted. `draw` issues a frame's
/// commands, in the display's context, which must be current.
[[nodiscard]] Duration measure_frame(LoopPlatform& platform, const std::function<void()>& draw);

}  // namespace foreview
