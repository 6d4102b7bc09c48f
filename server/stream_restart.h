#pragma once
#include <cstdint>
#include <optional>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// Tells a stream that begins anew (sender restarted, its clock set back, a recording sent in a loop) from pictures
/// that overtake each other on the way, and from a second publisher on the same topic. Pure.
///
/// A stream is one publisher's. Of its own pictures, stamps that go back begin it anew
///  - at once, where they lie 10 * `oldest` behind the newest seen,
///  - after three in a row that lie `oldest` behind,
///  - after 8 that count on from each other for half a second, all of them behind: no network holds up so many, and
///    lets none of the newer ones through. That is a clock set back by less than `oldest`.
/// Another publisher takes the stream over when three of its pictures came in a row and the first one has been silent
/// for half a second, or three of its last gaps where that is longer (5 s at most, and while no gap is known). Where
/// its stamps go on from there, so does the stream; where they do not, it begins anew, however little they lie behind.
class StreamRestart {
 public:
  explicit StreamRestart(Duration oldest = Duration{2'000'000'000}) : oldest_(oldest) {}

  enum class Verdict : std::uint8_t {
    continues,
    straggles,    ///< of another publisher, not newer than the stream: what is known at its stamp is not of its own
    begins_anew,  ///< with this picture
  };
  [[nodiscard]] Verdict note(Timestamp stamp, std::uint64_t publisher, Timestamp arrival);
  /// Whose the stream is; none before the first picture.
  [[nodiscard]] std::optional<std::uint64_t> publisher() const { return publisher_; }

 private:
  [[nodiscard]] Verdict note_own(Timestamp stamp, Timestamp arrival);
  [[nodiscard]] Verdict note_other(Timestamp stamp, std::uint64_t publisher, Timestamp arrival);
  void begin(Timestamp stamp, std::uint64_t publisher, Timestamp arrival);

  /// Pictures in a row.
  struct Run {
    int count = 0;
    std::uint64_t publisher = 0;
    Timestamp first_stamp, last_stamp, first_arrival;
  };
  static void add(Run& run, Timestamp stamp, Timestamp arrival);

  Duration oldest_;
  std::optional<std::uint64_t> publisher_;
  Timestamp newest_, last_arrival_;
  std::optional<Duration> gap_;  ///< between the last two of the publisher's pictures
  int far_in_a_row_ = 0;
  Run behind_;  ///< of the publisher's own, each newer than the one before it
  Run other_;   ///< of another publisher's
};

}  // namespace foreview
