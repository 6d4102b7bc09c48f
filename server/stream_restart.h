#pragma once
#include <optional>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// Tells a stream that begins anew (sender restarted, its clock set back, a recording sent in a loop) from pictures
/// that overtake each other on the way. Pure.
class StreamRestart {
 public:
  /// What is this much older than the newest seen, three times in a row, begins a new stream; ten times as old, at
  /// once.
  explicit StreamRestart(Duration oldest = Duration{2'000'000'000}) : oldest_(oldest) {}
  /// Whether with this stamp another stream has begun.
  [[nodiscard]] bool begins_anew(Timestamp stamp);

 private:
  Duration oldest_;
  std::optional<Timestamp> newest_;
  int in_a_row_ = 0;
};

}  // namespace foreview
