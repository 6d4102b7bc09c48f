#pragma once
#include <functional>

#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/pacing.h"

namespace foreview {

/// A run of DisplayLoop that is measured. Members that are called are called as DisplayLoop's.
struct PacingRequest {
  Duration period{20'000'000};
  Duration warm_up{2'000'000'000};  ///< not counted: shaders are compiled, costs are learnt
  Duration duration{20'000'000'000};
  bool extraction = true;
  DisplayLoop::Options loop;  ///< but the period
  std::function<void(const FrameMoment&)> draw;
  std::function<bool()> poll;  ///< false: enough
  /// Every PacingRun::kInterval, and at the end.
  std::function<void(const PacingRun::Interval&)> interval_ended;
  std::function<void(const PictureRecord&)> displayed;
  std::function<void()> at_end;      ///< textures are as the last frame has shown them, or newer
  LoopPlatform* platform = nullptr;  ///< instead of the scene's, over its contexts
};

/// Shows frames and extracts beside them.
[[nodiscard]] PacingRun measure_pacing(LiveScene& scene, FrameSource& source, const PacingRequest& request);
/// Extracts without any frames, as fast as can be.
[[nodiscard]] PacingRun measure_extraction_alone(LiveScene& scene, FrameSource& source, const PacingRequest& request);

}  // namespace foreview
