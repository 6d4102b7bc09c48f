#include "foreview/server/frame_source.h"

#include <chrono>

namespace foreview {

Timestamp steady_now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
              .count()};
}

}  // namespace foreview
