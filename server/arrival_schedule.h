#pragma once
#include <cstddef>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/server/simulated_link.h"

namespace foreview {

/// One picture of a recording, as it goes over a link.
struct SentPicture {
  std::size_t camera = 0, index = 0;
  Timestamp capture;
  std::size_t bytes = 0;  ///< of its file; 0 where it cannot be asked
};
/// All pictures of all cameras in the order of their capture, each sent at its capture.
[[nodiscard]] std::vector<SentPicture> pictures_of(const Recording& recording);

/// What becomes of the pictures on a link.
struct ArrivalSchedule {
  struct Event {
    Timestamp time;
    std::size_t picture = 0;  ///< place in the list of pictures
  };
  std::vector<Event> arrivals;  ///< ascending
  std::vector<Event> losses;    ///< when each lost picture was expected (capture and delay without jitter), ascending
};
/// A function of its arguments alone: a picture's fate does not depend on where playing began or what was sought.
[[nodiscard]] ArrivalSchedule schedule_arrivals(const std::vector<SentPicture>& pictures, const LinkOptions& options);

}  // namespace foreview
