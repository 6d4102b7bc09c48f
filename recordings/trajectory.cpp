#include <algorithm>

#include "foreview/recordings/recording.h"

namespace foreview {
namespace {

bool earlier(const Trajectory::Sample& sample, Timestamp stamp) {
  return sample.stamp < stamp;
}

}  // namespace

bool Trajectory::add(Timestamp stamp, const Pose& pose) {
  const auto place = std::lower_bound(samples_.begin(), samples_.end(), stamp, earlier);
  if (place != samples_.end() && place->stamp == stamp) return false;
  samples_.insert(place, {stamp, pose});
  return true;
}

std::optional<Pose> Trajectory::at(Timestamp stamp) const {
  const auto next = std::lower_bound(samples_.begin(), samples_.end(), stamp, earlier);
  if (next == samples_.end()) return std::nullopt;
  if (next->stamp == stamp) return next->pose;
  if (next == samples_.begin()) return std::nullopt;
  const Sample& before = *(next - 1);
  const double fraction = (stamp - before.stamp).seconds() / (next->stamp - before.stamp).seconds();
  return interpolate(before.pose, next->pose, fraction);
}

}  // namespace foreview
