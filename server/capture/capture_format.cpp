#include "foreview/server/capture/capture_format.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <set>
#include <tuple>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

struct Description {
  CaptureFormat format;
  const char *name, *encoding;
  std::uint32_t fourcc;
  std::size_t bytes_per_pixel;
};
constexpr std::array<Description, 4> kFormats{{
    {CaptureFormat::mjpeg, "MJPEG", "jpeg", V4L2_PIX_FMT_MJPEG, 0},
    {CaptureFormat::yuyv, "YUYV", "yuv422_yuy2", V4L2_PIX_FMT_YUYV, 2},
    {CaptureFormat::uyvy, "UYVY", "yuv422", V4L2_PIX_FMT_UYVY, 2},
    {CaptureFormat::grey, "GREY", "mono8", V4L2_PIX_FMT_GREY, 1},
}};

const Description& description_of(CaptureFormat format) {
  return kFormats[static_cast<std::size_t>(format)];
}

/// Without rates, each once.
std::string list_of(const std::vector<CaptureMode>& modes, bool with_size) {
  std::set<std::string> texts;
  for (CaptureMode mode : modes) {
    mode.interval_numerator = 0;
    texts.insert(with_size ? mode.to_string() : name_of(mode.format));
  }
  constexpr std::size_t kMost = 24;
  std::string list;
  std::size_t count = 0;
  for (const std::string& text : texts) {
    if (count++ == kMost) return list + ", ...";
    list += (list.empty() ? "" : ", ") + text;
  }
  return list;
}

}  // namespace

const char* name_of(CaptureFormat format) {
  return description_of(format).name;
}

const char* encoding_of(CaptureFormat format) {
  return description_of(format).encoding;
}

std::size_t bytes_per_pixel(CaptureFormat format) {
  return description_of(format).bytes_per_pixel;
}

CaptureFormat parse_capture_format(const std::string& text, const std::string& what) {
  std::string upper = text;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  for (const Description& format : kFormats) {
    if (upper == format.name) return format.format;
  }
  throw InputError(what, "'" + text + "' is no format of a camera; expected mjpeg, yuyv, uyvy or grey");
}

std::optional<CaptureFormat> capture_format_of(std::uint32_t fourcc) {
  if (fourcc == V4L2_PIX_FMT_JPEG) return CaptureFormat::mjpeg;
  for (const Description& format : kFormats) {
    if (fourcc == format.fourcc) return format.format;
  }
  return std::nullopt;
}

std::string CaptureMode::to_string() const {
  std::string text = name_of(format);
  if (width > 0) text += " " + std::to_string(width) + "x" + std::to_string(height);
  if (rate() > 0) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), " at %.4g Hz", rate());
    text += buffer.data();
  }
  return text;
}

CaptureMode choose_mode(const std::vector<CaptureMode>& modes, const CaptureWish& wish, const std::string& device) {
  std::vector<CaptureMode> left = modes;
  if (left.empty()) throw InputError(device, "has no format that is taken; expected MJPEG, YUYV, UYVY or GREY");
  if (wish.format) {
    std::erase_if(left, [&](const CaptureMode& mode) { return mode.format != *wish.format; });
    if (left.empty()) {
      throw InputError(device,
                       std::string("has no ") + name_of(*wish.format) + "; expected one of " + list_of(modes, false));
    }
  }
  if (wish.width > 0) {
    const std::vector<CaptureMode> of_format = left;
    std::erase_if(left, [&](const CaptureMode& mode) {
      return mode.width > 0 && (mode.width != wish.width || mode.height != wish.height);
    });
    if (left.empty()) {
      throw InputError(device, "has no pictures of " + std::to_string(wish.width) + "x" + std::to_string(wish.height) +
                                   "; expected one of " + list_of(of_format, true));
    }
  }
  const double wanted = wish.rate > 0 ? wish.rate : 25;
  constexpr std::int64_t kMostPixels = std::int64_t{1920} * 1080;
  // Less is better.
  const auto order = [&](const CaptureMode& mode) {
    const std::int64_t pixels = std::int64_t{mode.width} * mode.height;
    // 1 %: a camera for 30 Hz may say 29.97.
    const bool is_slow = mode.rate() > 0 && mode.rate() < 0.99 * wanted;
    const bool is_large = wish.width == 0 && pixels > kMostPixels;
    const double beyond = wish.rate > 0 ? mode.rate() - wanted : -mode.rate();
    return std::make_tuple(is_large, is_slow, is_slow ? -mode.rate() : 0.0, is_large ? pixels : -pixels, mode.format,
                           beyond);
  };
  return *std::min_element(left.begin(), left.end(),
                           [&](const CaptureMode& a, const CaptureMode& b) { return order(a) < order(b); });
}

}  // namespace foreview
