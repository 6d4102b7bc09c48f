#include "foreview/server/stream_restart.h"

namespace foreview {

bool StreamRestart::begins_anew(Timestamp stamp) {
  if (!newest_ || stamp >= *newest_) {
    newest_ = stamp;
    in_a_row_ = 0;
    return false;
  }
  const Duration age = *newest_ - stamp;
  in_a_row_ = age > oldest_ ? in_a_row_ + 1 : 0;
  const bool is_far = age.nanoseconds / 10 > oldest_.nanoseconds;
  constexpr int kInARow = 3;
  if (in_a_row_ < kInARow && !is_far) return false;
  newest_ = stamp;
  in_a_row_ = 0;
  return true;
}

}  // namespace foreview
