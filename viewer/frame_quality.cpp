#include "foreview/viewer/frame_quality.h"

#include <algorithm>
#include <array>

namespace foreview {

ViewQuality quality_that_fits(Duration full_frame, Duration period) {
  return full_frame.seconds() <= kFullQualityPart * period.seconds() ? ViewQuality::full : ViewQuality::fast;
}

bool is_software_renderer(std::string_view renderer) {
  return renderer.find("llvmpipe") != std::string_view::npos || renderer.find("softpipe") != std::string_view::npos;
}

Duration measure_frame(LoopPlatform& platform, const std::function<void()>& draw) {
  std::array<Duration, 5> took{};
  draw();  // shaders are compiled
  platform.finish("a frame");
  for (Duration& each : took) {
    const Timestamp begun = platform.now();
    draw();
    platform.finish("a frame");
    each = platform.now() - begun;
  }
  std::nth_element(took.begin(), took.begin() + 2, took.end());
  return took[2];
}

}  // namespace foreview
