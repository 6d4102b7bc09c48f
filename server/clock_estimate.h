#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// Whether stamps can be compared with the operator's clock as they are.
enum class ClockMode : std::uint8_t {
  estimated,     ///< the clocks have nothing to do with each other: offset and drift are estimated
  synchronised,  ///< by PTP, NTP or because they are one: stamps are taken as they are
};

/// Between the clock of a sender (the robot) and the operator's, from the stamps of what arrives: each packet tells
/// when it was stamped there and when it arrived here. One estimate per sending clock.
///
/// Method: arrival - stamp is the clocks' offset, which drifts, plus a delay, which is never less than the link's
/// least. Over a sliding window these differences therefore lie above a line, and touch it where a packet had luck. The
/// line is the edge of their lower convex hull at the window's middle: of all lines below every pair the one nearest to
/// them (S. Moon, P. Skelly, D. Towsley: Estimation and removal of clock skew from network delay measurements, 1999).
/// Jitter, loss, reordering, queues and silence only leave it less to touch.
///
/// What cannot be known from one direction alone: the least delay itself. A packet that never takes less than 100 ms
/// and a clock that is 100 ms behind look the same. operator_time() therefore is when the stamped moment would have
/// been *seen here by the fastest packet*, and latency() is what comes on top of that: too small by the least delay,
/// unless `least_delay` says how much that is (half of a ping's least round trip is a good guess; exactly half only
/// where both ways are alike). Nor can a lasting rise of the delay be told from a clock set back, nor a fall from one
/// set forward:
///  - a change smaller than `jump` (a new route, a small step of the clock) moves the line at once when the delay
///  falls,
///    and when it rises after `window` at the latest; until then latency() shows the rise as what it may be, a delay;
///  - a fall by more than `jump` that all packets stamped later share is a clock set forward, or begun anew: three
///    packets that agree begin a new estimate;
///  - stamps that go back by more than `jump` and count on from there are a clock set back: after 8 packets and half a
///    second, all behind what had come before, a new estimate begins. Packets held up by the network do not look so:
///    between them newer ones arrive;
///  - a rise by more than 4 * `jump` that lasts for 10 s and hardly varies begins a new estimate too;
///  - a single stamp that fits nothing (a damaged message) is counted and left out.
///
/// Accuracy (tests/server/clock_estimate_test.cpp: 30 Hz, a fifth lost, drift within +-100 ppm, 40 runs of 180 s;
/// against the truth of the simulation, at the moment of each packet's arrival):
///     jitter on top of the floor      worst run's median   worst from 20 s   from 60 s   drift, from 60 s
///     none                                  < 1 us              < 1 us        < 1 us        < 0.1 ppm
///     exponential, mean 30 ms               0.13 ms             1.1 ms        0.8 ms         24 ppm
///     uniform up to 200 ms                  0.8 ms              3.7 ms        3.6 ms         91 ppm
///     half normal, 200 ms                   1.1 ms              7.0 ms        3.2 ms         76 ppm
///     two uniform up to 100 ms each         9.6 ms               16 ms         15 ms        257 ppm
/// In the last row almost no packet comes near the floor, which no method could know of.
/// Cost: one comparison per pair, a pass over at most 121 points whenever the lowest of half a second changes or a new
/// half second begins; memory for those 121 points. Pure: no clock, no thread; not thread-safe.
class ClockEstimate {
 public:
  struct Options {
    ClockMode mode = ClockMode::estimated;
    Duration window{60'000'000'000};
    double most_drift = 200e-6;  ///< of the one clock against the other; crystals stay within 100e-6 each
    Duration jump{500'000'000};
    Duration least_delay{};  ///< of the link, where it is known; latency() then includes it
  };
  /// Throws InputError naming the option on times that are not positive (least_delay: negative), a drift outside
  /// 0..0.01.
  explicit ClockEstimate(Options options);

  /// A packet stamped `stamp` by the sender has arrived at `arrival`: of a clock of the operator that does not go back
  /// (std::chrono::steady_clock), or, synchronised, of the clock that is. In the order of arrival.
  void observe(Timestamp stamp, Timestamp arrival);

  /// The moment of a stamp on the operator's clock. None before the first pair (synchronised: always known).
  [[nodiscard]] std::optional<Timestamp> operator_time(Timestamp stamp) const;
  /// The other way round: what the sender's clock shows at a moment of the operator's.
  [[nodiscard]] std::optional<Timestamp> sender_time(Timestamp moment) const;
  /// How old what was stamped is at `moment` of the operator's clock; never negative.
  [[nodiscard]] std::optional<Duration> latency(Timestamp stamp, Timestamp moment) const;

  struct State {
    bool is_known = false;
    Duration offset;               ///< to be added to the sender's newest stamp
    double drift = 0;              ///< seconds that the sender's clock gains per second of the operator's
    double drift_uncertainty = 0;  ///< most_drift while nothing is known of it
    /// How far operator_time() may be off at `moment`, beside the least delay. Grows with silence. Not a bound: made
    /// from how densely pairs lie along the line, so that about 95 of 100 errors are smaller.
    Duration uncertainty;
    std::size_t pairs = 0;     ///< observed
    std::size_t jumps = 0;     ///< estimates begun anew
    std::size_t outliers = 0;  ///< stamps that fitted nothing
    std::string warning;       ///< one line; empty: nothing. Synchronised, where stamps lie in the future
  };
  [[nodiscard]] State state(Timestamp moment) const;
  [[nodiscard]] const Options& options() const { return options_; }

 private:
  struct Pair {
    Timestamp stamp, arrival;
  };
  /// Relative to reference_, nanoseconds.
  struct Point {
    double arrival = 0, difference = 0;
  };
  struct Bucket {
    std::int64_t number = 0;
    Point lowest, highest;
  };
  /// Pairs in a row that may be those of a clock set back.
  struct Run {
    std::size_t count = 0;
    Timestamp begin;
    Pair best;
    double least = 0, most = 0;  ///< above the line
    void add(const Pair& pair, double above);
  };

  void observe_synchronised(const Pair& pair);
  void begin(const Pair& first);
  void begin_anew(const Pair& first, const Pair& second);
  void add(const Pair& pair);
  /// Whether the pair is so far below the line that it is kept apart.
  [[nodiscard]] bool set_apart(const Pair& pair, double above);
  [[nodiscard]] bool began_anew_after_run(const Pair& pair, double above);
  /// How far above the line the slower packets of half a second lie, as a rule.
  [[nodiscard]] double usual_spread() const;
  void fit();
  [[nodiscard]] double slope_of_hull() const;
  [[nodiscard]] Point point_of(const Pair& pair) const;
  [[nodiscard]] double line_at(double arrival) const { return intercept_ + slope_ * arrival; }

  Options options_;
  std::optional<Pair> reference_;
  std::vector<Bucket> buckets_;  ///< of the window, oldest first; the lowest pair of each
  std::vector<Point> hull_;      ///< of the buckets' points, lower side, left to right
  double intercept_ = 0, slope_ = 0;
  double expected_slope_ = 0;                         ///< what it has been for some windows; 0 at first
  double mean_arrival_ = 0, span_ = 0, spacing_ = 0;  ///< of the fit; spacing_: between the lowest points and the line
  Timestamp newest_stamp_, last_arrival_;
  std::vector<Pair> suspects_;  ///< far below the line, agreeing with each other; at most 3
  bool suspects_contradicted_ = false;
  Run behind_, above_;
  std::size_t pairs_ = 0, jumps_ = 0, outliers_ = 0;
  Duration furthest_ahead_;  ///< of stamps, synchronised, lately
  Timestamp ahead_at_;
};

}  // namespace foreview
