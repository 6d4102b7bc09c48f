#include "foreview/server/capture/video_modes.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace foreview {
namespace {

// A driver that never ends a list must not keep anybody.
constexpr std::uint32_t kMostFormats = 64, kMostSizes = 256, kMostIntervals = 64;
constexpr std::size_t kMostModes = 4096;
constexpr std::uint32_t kMostExtent = 32768;

using Size = std::pair<std::uint32_t, std::uint32_t>;
using Interval = std::pair<std::uint32_t, std::uint32_t>;  // numerator, denominator

bool is_within(std::uint32_t value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
  return value >= least && value <= most && (step <= 1 || (value - least) % step == 0);
}

std::vector<Size> list_sizes(VideoSystem& system, int file, std::uint32_t fourcc, const CaptureWish& wish) {
  std::set<Size> sizes;
  for (std::uint32_t index = 0; index < kMostSizes; ++index) {
    v4l2_frmsizeenum answer{};
    answer.index = index;
    answer.pixel_format = fourcc;
    if (video_ioctl(system, file, VIDIOC_ENUM_FRAMESIZES, answer) < 0) break;
    if (answer.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      sizes.emplace(answer.discrete.width, answer.discrete.height);
      continue;
    }
    const v4l2_frmsize_stepwise& range = answer.stepwise;
    sizes.emplace(range.min_width, range.min_height);
    sizes.emplace(range.max_width, range.max_height);
    const Size wished(wish.width, wish.height);
    for (const Size& size : {Size(640, 480), Size(1280, 720), Size(1920, 1080), wished}) {
      if (is_within(size.first, range.min_width, range.max_width, range.step_width) &&
          is_within(size.second, range.min_height, range.max_height, range.step_height)) {
        sizes.insert(size);
      }
    }
    break;
  }
  std::erase_if(sizes, [](const Size& size) {
    return size.first == 0 || size.second == 0 || size.first > kMostExtent || size.second > kMostExtent;
  });
  return {sizes.begin(), sizes.end()};
}

std::vector<Interval> list_intervals(VideoSystem& system, int file, std::uint32_t fourcc, const Size& size,
                                     const CaptureWish& wish) {
  std::vector<Interval> intervals;
  for (std::uint32_t index = 0; index < kMostIntervals; ++index) {
    v4l2_frmivalenum answer{};
    answer.index = index;
    answer.pixel_format = fourcc;
    answer.width = size.first;
    answer.height = size.second;
    if (video_ioctl(system, file, VIDIOC_ENUM_FRAMEINTERVALS, answer) < 0) break;
    if (answer.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      intervals.emplace_back(answer.discrete.numerator, answer.discrete.denominator);
      continue;
    }
    const v4l2_fract &least = answer.stepwise.min, &most = answer.stepwise.max;
    intervals.emplace_back(least.numerator, least.denominator);
    intervals.emplace_back(most.numerator, most.denominator);
    const double seconds = wish.rate > 0 ? 1 / wish.rate : 0;
    if (least.denominator > 0 && most.denominator > 0 && seconds > least.numerator / double{1} / least.denominator &&
        seconds < most.numerator / double{1} / most.denominator) {
      intervals.emplace_back(1000, static_cast<std::uint32_t>(std::min(std::lround(wish.rate * 1000), 1'000'000'000L)));
    }
    break;
  }
  std::erase_if(intervals, [](const Interval& interval) { return interval.first == 0 || interval.second == 0; });
  return intervals;
}

}  // namespace

std::vector<CaptureMode> list_modes(VideoSystem& system, int file, const CaptureWish& wish) {
  std::vector<CaptureMode> modes;
  for (std::uint32_t index = 0; index < kMostFormats && modes.size() < kMostModes; ++index) {
    v4l2_fmtdesc answer{};
    answer.index = index;
    answer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (video_ioctl(system, file, VIDIOC_ENUM_FMT, answer) < 0) break;
    const std::optional<CaptureFormat> format = capture_format_of(answer.pixelformat);
    if (!format) continue;
    std::vector<Size> sizes = list_sizes(system, file, answer.pixelformat, wish);
    if (sizes.empty()) sizes.emplace_back(0, 0);
    for (const Size& size : sizes) {
      std::vector<Interval> intervals;
      if (size.first > 0) intervals = list_intervals(system, file, answer.pixelformat, size, wish);
      if (intervals.empty()) intervals.emplace_back(0, 0);
      for (const Interval& interval : intervals) {
        if (modes.size() == kMostModes) break;
        modes.push_back({*format, answer.pixelformat, static_cast<int>(size.first), static_cast<int>(size.second),
                         interval.first, interval.second});
      }
    }
  }
  return modes;
}

}  // namespace foreview
