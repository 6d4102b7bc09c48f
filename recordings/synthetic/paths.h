#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace foreview::synthetic {

/// A value at a time.
template <class Value>
struct Key {
  double time;
  Value value;
};

/// Between keys along a quintic that stands still at each of them (least jerk): how an arm moves from point to point.
template <class Value>
[[nodiscard]] Value stop_and_go(const std::vector<Key<Value>>& keys, double t) {
  if (t <= keys.front().time) return keys.front().value;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (t > keys[i].time) continue;
    const double s = (t - keys[i - 1].time) / (keys[i].time - keys[i - 1].time);
    return keys[i - 1].value + (keys[i].value - keys[i - 1].value) * (s * s * s * (10 + s * (6 * s - 15)));
  }
  return keys.back().value;
}

/// Through keys without stopping (cubic, slopes from the neighbours): how a head looks around.
template <class Value>
[[nodiscard]] Value smooth_through(const std::vector<Key<Value>>& keys, double t) {
  if (t <= keys.front().time) return keys.front().value;
  if (t >= keys.back().time) return keys.back().value;
  std::size_t i = 1;
  while (t > keys[i].time) ++i;
  const auto slope = [&](std::size_t k) {
    const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, keys.size() - 1);
    return (keys[after].value - keys[before].value) * (1 / (keys[after].time - keys[before].time));
  };
  const double length = keys[i].time - keys[i - 1].time, s = (t - keys[i - 1].time) / length;
  const Value from = keys[i - 1].value, to = keys[i].value;
  const Value from_slope = slope(i - 1) * length, to_slope = slope(i) * length;
  return from * (1 + s * s * (2 * s - 3)) + to * (s * s * (3 - 2 * s)) + from_slope * (s * (1 + s * (s - 2))) +
         to_slope * (s * s * (s - 1));
}

}  // namespace foreview::synthetic
