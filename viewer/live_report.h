#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "foreview/server/frame_source.h"
#include "foreview/server/live_source.h"

namespace foreview {

/// What there is to tell of live streams beside SourceStatus: by camera, and how late pictures are.
struct LiveReport {
  struct Camera {
    std::string name, topic;
    PictureCounts counts;  ///< `lost` on the simulated link
    std::size_t lost_on_network = 0;
  };
  std::vector<Camera> cameras;
  LiveSource::Latency latency;
  std::size_t displayed = 0;            ///< pictures
  Duration display_median, display_p99; /**< of the last ones: from capture to the first frame with their textures, by
                                             the clocks' estimate */
  std::string missing;                  ///< LiveReceiver::missing()
};

/// "cameras", "latency_ms", "clock", "missing"; described in docs/live.md.
[[nodiscard]] nlohmann::ordered_json to_json(const LiveReport& report);
/// One line for the terminal: what came, what became of it, how late it is shown.
[[nodiscard]] std::string to_text(const LiveReport& report);

}  // namespace foreview
