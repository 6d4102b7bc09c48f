#pragma once
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "foreview/scene/pose.h"
#include "foreview/scene/timestamp.h"

namespace foreview {

/// A tree of frames that move against each other, as ROS 2's tf keeps it: of each frame its parent, and where it was
/// in it, over the last `memory`. Between stamps poses are interpolated, outside them nothing is known (never
/// extrapolated). Static transforms hold at all times. Memory is bounded whatever is added. Not thread-safe; no clock:
/// old is what lies behind the newest stamp of the same frame.
class TfBuffer {
 public:
  struct Options {
    Duration memory{10'000'000'000};
    std::size_t most_frames = 1000;
    std::size_t most_samples = 20'000;  ///< per frame; more than that in `memory`: the oldest go
  };
  TfBuffer() : TfBuffer(Options()) {}
  explicit TfBuffer(Options options) : options_(options) {}

  /// Where `child` was in `parent` at `stamp`. Refused (false): numbers that are not finite or beyond 1e9 m, a
  /// quaternion off unit length by more than 0.01 (less: normalised), no name or a frame in itself, more frames than
  /// allowed, older than `memory`, a stamp that is there already. A new parent forgets what was in the old one.
  bool add(const std::string& parent, const std::string& child, Timestamp stamp, const Pose& parent_from_child,
           bool is_static = false);

  /// target_from_source at a time; none where the frames are not connected, or a link between them is not known then.
  [[nodiscard]] std::optional<Pose> at(const std::string& target, const std::string& source, Timestamp time) const;
  /// The newest time at which target_from_source is known; `now` where nothing between them moves; none where they are
  /// not connected.
  [[nodiscard]] std::optional<Timestamp> newest(const std::string& target, const std::string& source,
                                                Timestamp now) const;
  [[nodiscard]] bool has(const std::string& frame) const;
  [[nodiscard]] std::size_t frames() const { return links_.size(); }
  [[nodiscard]] std::size_t samples() const;
  /// Forgets all that moves; static transforms stay.
  void clear_moving();

 private:
  struct Sample {
    Timestamp stamp;
    Pose parent_from_child;
  };
  struct Link {
    std::string parent;
    bool is_static = false;
    std::deque<Sample> samples;  ///< ascending stamps; one where static
    [[nodiscard]] std::optional<Pose> at(Timestamp time) const;
  };
  struct Step {
    const Link* link;
    std::string frame;  ///< the parent that the link leads to
  };
  /// From a frame up to the root; cut off where the tree runs in a circle.
  [[nodiscard]] std::vector<Step> way_up(const std::string& frame) const;
  struct Chain {
    std::vector<const Link*> from_target, from_source;  ///< up to where they meet
  };
  [[nodiscard]] std::optional<Chain> chain(const std::string& target, const std::string& source) const;

  Options options_;
  std::map<std::string, Link> links_;  ///< by child
};

}  // namespace foreview
