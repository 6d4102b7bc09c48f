#include "foreview/viewer/frame_schedule.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace foreview {
namespace {

constexpr Duration kStop{1'000'000'000};
constexpr std::size_t kShownAtOnce = 4;
/// What the median frame must be cheaper than a rate allows before that rate is taken up again: no flickering between
/// two rates.
constexpr double kFasterRateReserve = 1.1;

std::int64_t divide_up(std::int64_t a, std::int64_t positive) {
  return a > 0 ? (a - 1) / positive + 1 : a / positive;
}

Duration part(double ratio, Duration of) {
  return {static_cast<std::int64_t>(std::ceil(ratio * static_cast<double>(of.nanoseconds)))};
}

double ratio(Duration a, Duration b) {
  return static_cast<double>(a.nanoseconds) / static_cast<double>(b.nanoseconds);
}

}  // namespace

FrameSchedule::FrameSchedule(Options options, Timestamp start)
    : options_(std::move(options)),
      frame_ratio_(options_.cost),
      slice_ratios_(options_.slices.size(), LearntCost(options_.slice_cost.value_or(options_.cost))),
      last_(start),
      aim_(start),
      grant_end_(start),
      latest_(start),
      expected_(start) {
  assert(options_.period > Duration{} && options_.frame > Duration{} && options_.margin >= Duration{});
  assert(options_.patience >= 1);
  update_submultiple();
  aim_on_grid(start, start);
}

Duration FrameSchedule::bound(const Slice& slice) const {
  assert(slice.kind < options_.slices.size() && slice.size >= 0);
  const Bound& declared = options_.slices[slice.kind];
  const Duration result = declared.constant + part(slice.size, declared.per_unit);
  assert(result > Duration{});
  return result;
}

Duration FrameSchedule::cost(const Slice& slice) const {
  return part(slice_ratios_.at(slice.kind).high(), bound(slice));
}

Duration FrameSchedule::frame_cost() const {
  const Duration affordable{submultiple_ * options_.period.nanoseconds - options_.margin.nanoseconds};
  const Duration high = part(frame_ratio_.high(ratio(affordable, options_.frame)), options_.frame);
  return std::min(high, affordable);  // rounded up, it might be a nanosecond more
}

double FrameSchedule::size_within(std::size_t kind, Duration duration) const {
  return size_within(kind, duration, slice_ratios_.at(kind).high());
}

double FrameSchedule::typical_size_within(std::size_t kind, Duration duration) const {
  return size_within(kind, duration, slice_ratios_.at(kind).median());
}

double FrameSchedule::size_within(std::size_t kind, Duration duration, double per_declared) const {
  const Bound& declared = options_.slices.at(kind);
  // Two nanoseconds less: cost() rounds up twice.
  const double left = (static_cast<double>(duration.nanoseconds) - 2) / per_declared -
                      static_cast<double>(declared.constant.nanoseconds) - 1;
  if (!(left > 0)) {
    return 0;
  }
  return declared.per_unit > Duration{} ? left / static_cast<double>(declared.per_unit.nanoseconds)
                                        : std::numeric_limits<double>::infinity();
}

Duration FrameSchedule::reserve() const {
  return frame_cost() + options_.margin;
}

Timestamp FrameSchedule::frame_start() const {
  return aim_ - reserve();
}

Timestamp FrameSchedule::reachable(Timestamp aim, Timestamp start, Duration delay) const {
  const Duration behind = start + reserve() - (aim + delay);
  const std::int64_t periods = std::max<std::int64_t>(0, divide_up(behind.nanoseconds, options_.period.nanoseconds));
  return aim + Duration{periods * options_.period.nanoseconds};
}

void FrameSchedule::update_submultiple() {
  const auto needed = [&](double factor) {
    const Duration wanted = part(factor * frame_ratio_.median(), options_.frame) + options_.margin;
    return std::max<std::int64_t>(1, divide_up(wanted.nanoseconds, options_.period.nanoseconds));
  };
  submultiple_ = std::max(needed(1), std::min(submultiple_, needed(kFasterRateReserve)));
}

void FrameSchedule::set_period(Duration period, Timestamp now) {
  assert(period > Duration{});
  notice(now);
  options_.period = period;
  update_submultiple();
  // Not the next point of the new grid after what a frame can meet: with the rate changed at each frame's start, as a
  // slider does it, that would put the frame off for ever.
  aim_from(std::max(last_ + Duration{submultiple_ * period.nanoseconds}, now + reserve()));
}

void FrameSchedule::set_grid(Duration period, Timestamp deadline, Timestamp now) {
  assert(period > Duration{});
  notice(now);
  options_.period = period;
  update_submultiple();
  aim_on_grid(deadline, now);
}

void FrameSchedule::set_slices(std::vector<Bound> slices) {
  assert(in_flight_ != InFlight::slice);
  options_.slices = std::move(slices);
  slice_ratios_.assign(options_.slices.size(), LearntCost(options_.slice_cost.value_or(options_.cost)));
}

void FrameSchedule::aim_on_grid(Timestamp deadline, Timestamp now) {
  const std::int64_t period = options_.period.nanoseconds;
  // Nearer than half a period to the last deadline lies the same deadline, moved.
  const Timestamp earliest = std::max(now + reserve(), last_ + Duration{submultiple_ * period - period / 2});
  aim_from(deadline + Duration{divide_up((earliest - deadline).nanoseconds, period) * period});
}

void FrameSchedule::aim_from(Timestamp deadline) {
  aim_ = deadline;
  last_ = deadline - options_.period;
  aim_before_oversize_.reset();
}

void FrameSchedule::notice(Timestamp now) {
  if (now < latest_ || now > expected_ + kStop) {
    ++statistics_.stops;
    last_ = now - options_.period;
    aim_on_grid(aim_, now);
    grant_end_ = now;
    shown_.clear();
    expected_ = now;
  }
  latest_ = now;
  expected_ = std::max(expected_, now);
}

FrameSchedule::Decision FrameSchedule::next(Timestamp now, const std::optional<Slice>& slice) {
  assert(in_flight_ == InFlight::nothing);
  notice(now);
  aim_ = reachable(aim_, now, tolerance());
  work_waited_ = work_waited_ && slice;
  if (slice) {
    const Timestamp done = now + cost(*slice);
    if (done <= std::max(frame_start(), grant_end_)) {
      return {Action::run_slice, done, false};
    }
    if (is_starving() && starved_gaps_ + 1 >= options_.patience) {
      pass_over_to(aim_);
      ++statistics_.skipped;
      skipped_ = true;
      aim_ = aim_ + options_.period;
      grant_end_ = now + std::min(options_.t_min, options_.period);
      if (done > std::max(frame_start(), grant_end_)) {
        ++statistics_.oversize_slices;
        aim_before_oversize_ = aim_;
        aim_ = reachable(aim_, done, Duration{});
      }
      return {Action::run_slice, done, true};
    }
  }
  if (now >= frame_start()) {
    return {Action::draw_frame, aim_, false};
  }
  expected_ = std::max(expected_, frame_start());
  return {Action::wait_until, frame_start(), false};
}

/// Disposes of the deadlines up to `deadline`: those before it were missed.
void FrameSchedule::pass_over_to(Timestamp deadline) {
  const std::int64_t deadlines = (deadline - last_).nanoseconds / options_.period.nanoseconds;
  statistics_.missed += deadlines - 1;
  statistics_.due += deadlines;
  last_ = deadline;
}

std::int64_t FrameSchedule::frame_started(Timestamp now) {
  assert(in_flight_ == InFlight::nothing);
  notice(now);
  in_flight_ = InFlight::frame;
  started_ = now;
  reckoned_ = frame_cost();
  expected_ = now + reckoned_;
  starved_gaps_ = is_starving() ? starved_gaps_ + 1 : 0;
  pass_over_to(aim_);
  const std::int64_t number = statistics_.frames++;
  if (shown_.size() == kShownAtOnce) {
    shown_.pop_front();
  }
  shown_.push_back({number, aim_});
  return number;
}

/// How long it took; nothing where the clock went back. At most what lets a stop be seen.
std::optional<Duration> FrameSchedule::end_of_work(Timestamp now) {
  notice(now);
  in_flight_ = InFlight::nothing;
  if (now < started_) {
    return std::nullopt;
  }
  return std::min(now - started_, reckoned_ + kStop);
}

void FrameSchedule::frame_handed_over(Timestamp now) {
  assert(in_flight_ == InFlight::frame);
  if (const auto took = end_of_work(now)) {
    statistics_.frame_overruns += *took > reckoned_ ? 1 : 0;
    frame_ratio_.observe(ratio(*took, options_.frame));
  }
  update_submultiple();
  const Timestamp wanted = last_ + Duration{submultiple_ * options_.period.nanoseconds};
  // Frames that fill the period would carry a delay on for ever: only cheaper ones can make up for it.
  aim_ = reachable(wanted, now, reserve() < options_.period ? tolerance() : Duration{});
  work_waited_ = true;
  skipped_ = false;
  extraction_ = {};
}

void FrameSchedule::frame_completed(std::int64_t number, Timestamp when) {
  const auto frame =
      std::find_if(shown_.begin(), shown_.end(), [&](const ShownFrame& f) { return f.number == number; });
  if (frame == shown_.end()) {
    return;  // the clock jumped meanwhile, or it comes too late
  }
  if (const Duration lateness = when - frame->deadline; lateness > Duration{}) {
    ++statistics_.late;
    statistics_.worst_lateness = std::max(statistics_.worst_lateness, lateness);
  }
  shown_.erase(frame);
}

void FrameSchedule::slice_started(const Slice& slice, Timestamp now) {
  assert(in_flight_ == InFlight::nothing);
  notice(now);
  in_flight_ = InFlight::slice;
  slice_ = slice;
  started_ = now;
  reckoned_ = cost(slice);
  expected_ = now + reckoned_;
}

void FrameSchedule::slice_completed(Timestamp now) {
  assert(in_flight_ == InFlight::slice);
  if (const auto took = end_of_work(now)) {
    statistics_.slice_overruns += *took > reckoned_ ? 1 : 0;
    slice_ratios_[slice_.kind].observe(ratio(*took, bound(slice_)));
    statistics_.extraction = statistics_.extraction + *took;
    extraction_ = extraction_ + *took;
  }
  ++statistics_.slices;
  if (aim_before_oversize_) {  // it may have been quicker than expected
    aim_ = std::min(aim_, reachable(*aim_before_oversize_, now, Duration{}));
    aim_before_oversize_.reset();
  }
}

}  // namespace foreview
