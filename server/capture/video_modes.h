#pragma once
#include <cerrno>
#include <vector>

#include "foreview/server/capture/capture_format.h"
#include "foreview/server/capture/video_system.h"

namespace foreview {

/// ioctl, begun again when a signal interrupts it. `argument` must be zeroed but for what the request reads.
template <class Argument>
[[nodiscard]] int video_ioctl(VideoSystem& system, int file, unsigned long request, Argument& argument) {
  int result = 0;
  do result = system.ioctl(file, request, &argument);
  while (result == -EINTR);
  return result;
}

/// The modes that an opened camera says it has (VIDIOC_ENUM_FMT, _FRAMESIZES, _FRAMEINTERVALS), those formats only that
/// are taken; at most 4096. Of a range of sizes or rates: its ends, common ones, and what is wished for if it lies
/// within. A driver that does not tell sizes or rates gives modes without.
[[nodiscard]] std::vector<CaptureMode> list_modes(VideoSystem& system, int file, const CaptureWish& wish);

}  // namespace foreview
