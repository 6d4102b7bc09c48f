#include "foreview/server/clock_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr std::int64_t kBuckets = 120;
constexpr std::size_t kSuspects = 3;
constexpr std::size_t kRunPairs = 8;
/// How far from the middle of the window the line may touch the hull, in windows.
constexpr double kReach = 0.2;
/// Beyond the fifth lowest point above the line; by simulation, see the test.
constexpr double kSpacings = 1.5;
constexpr double kLeastSpacing = 1000;  // ns: reading a clock takes that long
constexpr double kSpreadMargin = 50e6;
constexpr double kRunTime = 0.5e9;
constexpr std::size_t kRisePairs = 20;
constexpr double kRiseTime = 10e9;
/// Stamps this little in the future are no cause for a warning: PTP in software, or NTP on one network, do no better.
constexpr Duration kAheadTolerance{2'000'000};
constexpr Duration kWarningLasts{30'000'000'000};

/// Stamps come from outside and may be anything.
std::int64_t minus(std::int64_t a, std::int64_t b) {
  std::int64_t result = 0;
  if (!__builtin_sub_overflow(a, b, &result)) return result;
  return b < 0 ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}

std::int64_t plus(std::int64_t a, std::int64_t b) {
  std::int64_t result = 0;
  if (!__builtin_add_overflow(a, b, &result)) return result;
  return b > 0 ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}

Timestamp plus(Timestamp t, double nanoseconds) {
  constexpr double kMost = 9.2e18;
  return {plus(t.nanoseconds, std::llround(std::clamp(nanoseconds, -kMost, kMost)))};
}

double between(Timestamp from, Timestamp to) {
  return static_cast<double>(minus(to.nanoseconds, from.nanoseconds));
}

void check_positive(Duration time, const char* what) {
  if (time <= Duration{}) {
    throw InputError(what, std::to_string(time.seconds()) + " s is out of range; expected more than 0 s");
  }
}

}  // namespace

ClockEstimate::ClockEstimate(Options options) : options_(options) {
  check_positive(options.window, "clock window");
  check_positive(options.jump, "clock jump");
  if (options.least_delay < Duration{}) throw InputError("least delay", "is negative; expected 0 s or more");
  if (!(options.most_drift >= 0 && options.most_drift <= 0.01)) {
    throw InputError("most drift", std::to_string(options.most_drift) + " is no drift of a clock; expected 0 to 0.01");
  }
  buckets_.reserve(kBuckets + 1);
  hull_.reserve(kBuckets + 1);
}

void ClockEstimate::Run::add(const Pair& pair, double height) {
  if (count == 0 || height < least) {
    least = height;
    best = pair;
  }
  if (count == 0) {
    begin = pair.arrival;
    most = height;
  }
  most = std::max(most, height);
  ++count;
}

ClockEstimate::Point ClockEstimate::point_of(const Pair& pair) const {
  const double arrival = between(reference_->arrival, pair.arrival);
  return {arrival, arrival - between(reference_->stamp, pair.stamp)};
}

void ClockEstimate::observe(Timestamp stamp, Timestamp arrival) {
  const Pair pair{stamp, arrival};
  ++pairs_;
  if (options_.mode == ClockMode::synchronised) return observe_synchronised(pair);
  if (!reference_) {
    begin(pair);
    add(pair);
    return;
  }
  if (arrival < last_arrival_) return begin_anew(pair, pair);
  const Point point = point_of(pair);
  const double above = point.difference - line_at(point.arrival);
  if (set_apart(pair, above) || began_anew_after_run(pair, above)) return;
  add(pair);
}

void ClockEstimate::observe_synchronised(const Pair& pair) {
  const Duration ahead{minus(pair.stamp.nanoseconds, pair.arrival.nanoseconds)};
  const bool has_expired = between(ahead_at_, pair.arrival) > static_cast<double>(kWarningLasts.nanoseconds);
  if (ahead > kAheadTolerance && (ahead >= furthest_ahead_ || has_expired)) {
    furthest_ahead_ = ahead;
    ahead_at_ = pair.arrival;
  } else if (has_expired) {
    furthest_ahead_ = {};
  }
  reference_ = pair;
}

void ClockEstimate::begin(const Pair& first) {
  reference_ = first;
  buckets_.clear();
  intercept_ = slope_ = expected_slope_ = 0;
  newest_stamp_ = first.stamp;
  suspects_.clear();
  behind_ = above_ = {};
}

void ClockEstimate::begin_anew(const Pair& first, const Pair& second) {
  ++jumps_;
  begin(first);
  add(first);
  add(second);
}

bool ClockEstimate::set_apart(const Pair& pair, double above) {
  const auto jump = static_cast<double>(options_.jump.nanoseconds);
  const auto window = static_cast<double>(options_.window.nanoseconds);
  if (!suspects_.empty() && between(suspects_.back().arrival, pair.arrival) > window) {
    outliers_ += suspects_.size();
    suspects_.clear();
  }
  if (above >= -jump) {
    // After a clock was set forward, whatever is sent later lies beyond, and this pair does not.
    if (!suspects_.empty() && !suspects_contradicted_) {
      suspects_contradicted_ = pair.stamp > suspects_.front().stamp ||
                               between(suspects_.front().arrival, pair.arrival) > usual_spread() + kSpreadMargin;
    }
    return false;
  }
  if (!suspects_.empty() && std::abs(point_of(suspects_.back()).difference - point_of(pair).difference) > jump) {
    outliers_ += suspects_.size();
    suspects_.clear();
  }
  if (suspects_.empty()) suspects_contradicted_ = false;
  suspects_.push_back(pair);
  if (suspects_.size() < kSuspects) return true;
  if (suspects_contradicted_) {
    // The link's luck, not the clock.
    suspects_.clear();
    return false;
  }
  // The lowest says most of the new offset; the newest is where time goes on.
  const Pair lowest = *std::min_element(suspects_.begin(), suspects_.end(), [&](const Pair& a, const Pair& b) {
    return point_of(a).difference < point_of(b).difference;
  });
  begin_anew(lowest, pair);
  return true;
}

bool ClockEstimate::began_anew_after_run(const Pair& pair, double above) {
  const auto jump = static_cast<double>(options_.jump.nanoseconds);
  if (pair.stamp > newest_stamp_) {
    behind_ = {};
  } else if (above > jump / 2 && (behind_.count > 0 || between(pair.stamp, newest_stamp_) > jump)) {
    behind_.add(pair, above);
  }
  if (above > 4 * jump) {
    above_.add(pair, above);
    // A queue that drains is no clock.
    if (above_.most - above_.least > above_.least / 2) above_ = {};
  } else {
    above_ = {};
  }
  // Where a few packets are faster by more than a jump, the others all are behind them; but no later than usual.
  const bool went_back = behind_.count >= kRunPairs && between(behind_.begin, pair.arrival) >= kRunTime &&
                         behind_.least > usual_spread() + jump / 2;
  const bool rose = above_.count >= kRisePairs && between(above_.begin, pair.arrival) >= kRiseTime;
  if (!went_back && !rose) return false;
  const Pair best = went_back ? behind_.best : above_.best;
  begin_anew(best, pair);
  return true;
}

double ClockEstimate::usual_spread() const {
  // The median lets neither a hold-up nor the packets of a jump in progress say what is usual.
  std::array<double, kBuckets + 1> spreads{};
  const auto end = std::transform(buckets_.begin(), buckets_.end(), spreads.begin(), [&](const Bucket& bucket) {
    return bucket.highest.difference - line_at(bucket.highest.arrival);
  });
  const auto middle = std::next(spreads.begin(), std::distance(spreads.begin(), end) / 2);
  std::nth_element(spreads.begin(), middle, end);
  return *middle;
}

void ClockEstimate::add(const Pair& pair) {
  newest_stamp_ = std::max(newest_stamp_, pair.stamp);
  last_arrival_ = pair.arrival;
  const Point point = point_of(pair);
  const double width = static_cast<double>(options_.window.nanoseconds) / kBuckets;
  const auto number = static_cast<std::int64_t>(std::floor(point.arrival / width));
  if (!buckets_.empty() && buckets_.back().number == number) {
    Point &lowest = buckets_.back().lowest, &highest = buckets_.back().highest;
    if (point.difference - highest.difference > slope_ * (point.arrival - highest.arrival)) highest = point;
    if (point.difference - lowest.difference >= slope_ * (point.arrival - lowest.arrival)) return;
    lowest = point;
  } else {
    const auto kept = std::find_if(buckets_.begin(), buckets_.end(),
                                   [&](const Bucket& bucket) { return bucket.number > number - kBuckets; });
    buckets_.erase(buckets_.begin(), kept);
    buckets_.push_back({number, point, point});
    expected_slope_ += (slope_ - expected_slope_) / kBuckets;
  }
  fit();
}

double ClockEstimate::slope_of_hull() const {
  // Over less, a slope would be made of jitter alone.
  if (12 * span_ < static_cast<double>(options_.window.nanoseconds)) return expected_slope_;
  // The line below all points of a given slope touches the hull in one place; of the line that is nearest to all
  // points, this place is the middle. Slopes for which it is not far from the middle are about as good, and of these
  // the one nearest to what is expected is the least made of jitter.
  const double reach = kReach * span_;
  const auto edge_over = [&](double arrival) {
    const auto right = std::find_if(std::next(hull_.begin()), std::prev(hull_.end()),
                                    [&](const Point& point) { return point.arrival >= arrival; });
    const Point &a = *std::prev(right), &b = *right;
    return (b.difference - a.difference) / (b.arrival - a.arrival);
  };
  const double least = edge_over(mean_arrival_ - reach), most = edge_over(mean_arrival_ + reach);
  return std::clamp(std::clamp(expected_slope_, least, most), -options_.most_drift, options_.most_drift);
}

void ClockEstimate::fit() {
  hull_.clear();
  double sum = 0;
  for (const Bucket& bucket : buckets_) {
    const Point& c = bucket.lowest;
    sum += c.arrival;
    while (hull_.size() >= 2) {
      const Point &a = hull_[hull_.size() - 2], &b = hull_.back();
      if ((b.difference - a.difference) * (c.arrival - a.arrival) <
          (c.difference - a.difference) * (b.arrival - a.arrival)) {
        break;
      }
      hull_.pop_back();
    }
    hull_.push_back(c);
  }
  mean_arrival_ = sum / static_cast<double>(buckets_.size());
  span_ = hull_.back().arrival - hull_.front().arrival;
  slope_ = slope_of_hull();
  intercept_ = std::numeric_limits<double>::infinity();
  for (const Point& point : hull_) intercept_ = std::min(intercept_, point.difference - slope_ * point.arrival);

  // The two points that carry the line have no distance; the next ones say how densely pairs lie above it.
  std::array<double, 5> lowest;
  lowest.fill(std::numeric_limits<double>::infinity());
  double most = 0;
  for (const Bucket& bucket : buckets_) {
    const double above = bucket.lowest.difference - line_at(bucket.lowest.arrival);
    most = std::max(most, above);
    if (above >= lowest.back()) continue;
    const auto place = std::upper_bound(lowest.begin(), lowest.end(), above);
    std::move_backward(place, std::prev(lowest.end()), lowest.end());
    *place = above;
  }
  spacing_ = kLeastSpacing + kSpacings * (std::isfinite(lowest.back()) ? lowest.back() : most);
}

std::optional<Timestamp> ClockEstimate::operator_time(Timestamp stamp) const {
  if (options_.mode == ClockMode::synchronised) return stamp;
  if (!reference_) return std::nullopt;
  const double since = between(reference_->stamp, stamp);
  const double correction = (intercept_ + slope_ * since) / (1 - slope_);
  const std::int64_t exact = minus(stamp.nanoseconds, reference_->stamp.nanoseconds);
  const Timestamp unshifted{plus(reference_->arrival.nanoseconds, exact)};
  return plus(unshifted, correction - static_cast<double>(options_.least_delay.nanoseconds));
}

std::optional<Timestamp> ClockEstimate::sender_time(Timestamp moment) const {
  if (options_.mode == ClockMode::synchronised) return moment;
  if (!reference_) return std::nullopt;
  const auto least = static_cast<double>(options_.least_delay.nanoseconds);
  const double since = between(reference_->arrival, moment) + least;
  const std::int64_t exact = minus(moment.nanoseconds, reference_->arrival.nanoseconds);
  const Timestamp unshifted{plus(reference_->stamp.nanoseconds, exact)};
  return plus(unshifted, least - line_at(since));
}

std::optional<Duration> ClockEstimate::latency(Timestamp stamp, Timestamp moment) const {
  const std::optional<Timestamp> taken = operator_time(stamp);
  if (!taken) return std::nullopt;
  return std::max(Duration{minus(moment.nanoseconds, taken->nanoseconds)}, Duration{});
}

ClockEstimate::State ClockEstimate::state(Timestamp moment) const {
  State state;
  state.pairs = pairs_;
  state.jumps = jumps_;
  state.outliers = outliers_;
  if (options_.mode == ClockMode::synchronised) {
    state.is_known = true;
    const bool is_recent = between(ahead_at_, moment) <= static_cast<double>(kWarningLasts.nanoseconds);
    if (furthest_ahead_ > Duration{} && is_recent) {
      state.warning = "stamps lie up to " + std::to_string(furthest_ahead_.nanoseconds / 1'000'000) +
                      " ms in the future: the clocks are not synchronised";
    }
    return state;
  }
  state.drift_uncertainty = options_.most_drift;
  if (!reference_) return state;
  state.is_known = true;
  state.offset = {minus(operator_time(newest_stamp_)->nanoseconds, newest_stamp_.nanoseconds)};
  state.drift = -slope_;
  if (span_ > 0) state.drift_uncertainty = std::min(4 * spacing_ / span_, options_.most_drift);
  const double distance = std::abs(between(reference_->arrival, moment) - mean_arrival_);
  state.uncertainty.nanoseconds = std::llround(std::min(spacing_ + state.drift_uncertainty * distance, 9e18));
  return state;
}

}  // namespace foreview
