#include "foreview/viewer/staleness.h"

#include <algorithm>
#include <cstdio>

namespace foreview {
namespace {

/// The one that is furthest beyond what is allowed, so far.
struct Worst {
  Duration age;
  double share = 0;  ///< of what is allowed beyond the delay
  const char* what = "picture";
  bool never = false;
};

Duration age_of(const std::optional<Timestamp>& newest, const StalenessInput& input) {
  return std::max(input.now - newest.value_or(input.since), Duration{0});
}

void compare(Worst& worst, const StalenessInput& input, const StalenessLimits& limits, const char* what,
             const std::optional<Timestamp>& newest) {
  const Duration age = age_of(newest, input);
  const double allowed = std::max(limits.beyond_delay.seconds(), 1e-3);
  const double share = (age.seconds() - input.expected_delay.seconds()) / allowed;
  if (share <= worst.share) return;
  worst = {age, share, what, !newest};
}

}  // namespace

const char* to_string(Staleness::Level level) {
  switch (level) {
    case Staleness::Level::fresh:
      return "fresh";
    case Staleness::Level::ageing:
      return "ageing";
    case Staleness::Level::stale:
      return "stale";
    case Staleness::Level::silent:
      return "silent";
  }
  return "";
}

Staleness assess_staleness(const StalenessInput& input, const StalenessLimits& limits) {
  Worst worst;
  worst.age = input.pictures_expected ? age_of(input.newest_picture, input) : Duration{0};
  if (input.pictures_expected) compare(worst, input, limits, "picture", input.newest_picture);
  if (input.poses_expected) compare(worst, input, limits, "camera pose", input.newest_pose);
  if (input.state_expected) compare(worst, input, limits, "robot state", input.newest_state);
  const Duration unheard = input.link_expected ? age_of(input.last_heard, input) : Duration{0};
  const bool silent = input.link_expected && unheard >= limits.silence;

  Staleness result;
  result.age = worst.age;
  // From half of what is allowed the colours go; at twice as much they are gone.
  result.severity = std::clamp((worst.share - 0.5) / 1.5, 0.0, 1.0);
  if (silent) result.severity = std::max(result.severity, 0.5);
  char text[128];
  if (silent) {
    result.level = Staleness::Level::silent;
    std::snprintf(text, sizeof text, "LINK SILENT for %.1f s", unheard.seconds());
    result.text = text;
    if (input.pictures_expected && input.newest_picture) {
      std::snprintf(text, sizeof text, ": newest picture %.1f s old", age_of(input.newest_picture, input).seconds());
      result.text += text;
    }
  } else if (worst.share >= 1) {
    result.level = Staleness::Level::stale;
    if (worst.never) {
      std::snprintf(text, sizeof text, "STALE: no %s for %.1f s", worst.what, worst.age.seconds());
    } else {
      std::snprintf(text, sizeof text, "STALE: newest %s %.1f s old", worst.what, worst.age.seconds());
    }
    result.text = text;
  } else if (worst.share > 0.5) {
    result.level = Staleness::Level::ageing;
  }
  return result;
}

}  // namespace foreview
