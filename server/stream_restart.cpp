#include "foreview/server/stream_restart.h"

#include <algorithm>

namespace foreview {
namespace {

constexpr int kInARow = 3;
constexpr int kLongRun = 8;
constexpr Duration kHalfASecond{500'000'000};
constexpr Duration kLongestSilence{5'000'000'000};

}  // namespace

void StreamRestart::begin(Timestamp stamp, std::uint64_t publisher, Timestamp arrival) {
  publisher_ = publisher;
  newest_ = stamp;
  last_arrival_ = arrival;
  gap_.reset();
  far_in_a_row_ = 0;
  behind_ = other_ = Run();
}

void StreamRestart::add(Run& run, Timestamp stamp, Timestamp arrival) {
  if (run.count == 0) {
    run.first_stamp = stamp;
    run.first_arrival = arrival;
  }
  run.last_stamp = stamp;
  ++run.count;
}

StreamRestart::Verdict StreamRestart::note(Timestamp stamp, std::uint64_t publisher, Timestamp arrival) {
  if (!publisher_) {
    begin(stamp, publisher, arrival);
    return Verdict::continues;
  }
  return publisher == *publisher_ ? note_own(stamp, arrival) : note_other(stamp, publisher, arrival);
}

StreamRestart::Verdict StreamRestart::note_own(Timestamp stamp, Timestamp arrival) {
  gap_ = arrival - last_arrival_;
  last_arrival_ = arrival;
  other_ = Run();
  if (stamp >= newest_) {
    newest_ = stamp;
    far_in_a_row_ = 0;
    behind_ = Run();
    return Verdict::continues;
  }
  const Duration age = newest_ - stamp;
  far_in_a_row_ = age > oldest_ ? far_in_a_row_ + 1 : 0;
  const bool is_far = age.nanoseconds / 10 > oldest_.nanoseconds;
  if (behind_.count > 0 && stamp <= behind_.last_stamp) behind_ = Run();
  add(behind_, stamp, arrival);
  const bool counts_on = behind_.count >= kLongRun && arrival - behind_.first_arrival >= kHalfASecond;
  if (far_in_a_row_ < kInARow && !is_far && !counts_on) return Verdict::continues;
  begin(stamp, *publisher_, arrival);
  return Verdict::begins_anew;
}

StreamRestart::Verdict StreamRestart::note_other(Timestamp stamp, std::uint64_t publisher, Timestamp arrival) {
  if (other_.publisher != publisher) other_ = Run();
  add(other_, stamp, arrival);
  other_.publisher = publisher;
  const Duration gap = gap_.value_or(kLongestSilence);
  const Duration usual{std::min(gap, kLongestSilence).nanoseconds * 3};
  const Duration silence = std::clamp(usual, kHalfASecond, kLongestSilence);
  const bool goes_on = other_.first_stamp > newest_ && stamp > newest_;
  if (other_.count < kInARow || arrival - last_arrival_ < silence) {
    return goes_on ? Verdict::continues : Verdict::straggles;
  }
  begin(stamp, publisher, arrival);
  return goes_on ? Verdict::continues : Verdict::begins_anew;
}

}  // namespace foreview
