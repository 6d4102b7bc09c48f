#pragma once
#include <optional>
#include <string>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// When what is shown counts as stale.
struct StalenessLimits {
  Duration beyond_delay{2'000'000'000};  ///< age of picture, pose or state beyond the delay that is expected
  Duration silence{2'000'000'000};       ///< without any sign of life from the link
};

/// What is known at a display instant; times are the display's. Of what a source does not have (a recording's link is
/// never silent), nothing is given, and nothing is said.
struct StalenessInput {
  Timestamp now;
  Timestamp since;                          ///< when waiting began: what has never come is as old as this
  Duration expected_delay;                  ///< what a picture is old when all is well
  bool pictures_expected = true;            ///< false: nothing is said of pictures
  std::optional<Timestamp> newest_picture;  ///< capture stamp of the newest picture in the textures
  bool poses_expected = false;              ///< of the operator's camera, of the site's parts: as for pictures
  std::optional<Timestamp> newest_pose;
  bool state_expected = false;
  std::optional<Timestamp> newest_state;
  bool link_expected = false;
  std::optional<Timestamp> last_heard;  ///< arrival of the last packet of any kind
};

/// Spec 13 and issue 4: an old prediction never passes for a fresh one.
struct Staleness {
  enum class Level {
    fresh,
    ageing,  ///< past half of what is allowed: the colours begin to go
    stale,   ///< border, text and age in the frame
    silent,  ///< the same, and nothing is heard from the other side
  };
  Level level = Level::fresh;
  Duration age;         ///< of the oldest of what is too old (of the picture where nothing is), delay included
  double severity = 0;  ///< 0 fresh .. 1: how much of the colour is taken out of the predicted view
  std::string
      text;  ///< for the frame, one line, ASCII: "STALE: newest picture 4.2 s old"; empty unless stale or silent
  bool operator==(const Staleness&) const = default;
};
[[nodiscard]] const char* to_string(Staleness::Level level);

/// Never throws; a time after `now` counts as now.
[[nodiscard]] Staleness assess_staleness(const StalenessInput& input, const StalenessLimits& limits = {});

}  // namespace foreview
