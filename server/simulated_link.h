#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// What a simulated link does to what is sent over it.
struct LinkOptions {
  Duration delay = {};   ///< every packet's, before jitter
  Duration jitter = {};  ///< standard deviation of a normal distribution; no packet arrives before it was sent
  std::vector<Duration> measured_delays =
      {};                 ///< where not empty, in place of delay and jitter: one of these at random
  double loss = 0;        ///< probability
  double reordering = 0;  ///< probability that a packet is held back by reordering_delay
  Duration reordering_delay{100'000'000};
  bool in_order = false;  ///< no packet overtakes another: a late one holds up those behind it, as TCP does
  double bandwidth = 0;   ///< bit/s; 0: no limit. Packets wait in a queue for those before them
  Duration longest_queue{1'000'000'000};  ///< a packet that would wait longer is lost (tail drop)
  std::uint64_t seed = 1;
  bool operator==(const LinkOptions&) const = default;
};

/// Throws InputError naming the option on negative times, probabilities outside 0..1, a bandwidth that is not finite.
void check_link_options(const LinkOptions& options);

/// A link that delays, loses and reorders. Pure: no clock, no thread, no network. The fate of the n-th packet depends
/// on the seed, n and the options at that time alone (and on the queue before it, where bandwidth is limited): the same
/// seed gives the same link on every machine, and changing one option does not change the luck of another.
class SimulatedLink {
 public:
  /// Throws InputError as check_link_options().
  explicit SimulatedLink(LinkOptions options);

  /// When a packet of `bytes` sent at `sent` arrives; none: it is lost. Send in order of `sent`.
  [[nodiscard]] std::optional<Timestamp> send(Timestamp sent, std::size_t bytes);
  /// For packets from now on; what is under way arrives as it would have. Throws InputError as check_link_options().
  void set_options(LinkOptions options);
  [[nodiscard]] const LinkOptions& options() const { return options_; }

 private:
  LinkOptions options_;
  std::uint64_t packets_ = 0;
  std::optional<Timestamp> queue_empty_;   ///< when the last packet has left the queue
  std::optional<Timestamp> last_arrival_;  ///< latest so far
};

/// Reads measured delays for LinkOptions: one per line, as "0.231", "231ms" or "231 ms"; '#' begins a comment. `where`
/// names the source. Throws InputError naming the line where one is no delay of 0 to 1 hour, and where there is none.
[[nodiscard]] std::vector<Duration> parse_measured_delays(const std::string& text, const std::string& where);

}  // namespace foreview
