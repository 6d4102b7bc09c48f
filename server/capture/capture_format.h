#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace foreview {

/// Pixel formats of cameras that are taken.
enum class CaptureFormat : std::uint8_t { mjpeg, yuyv, uyvy, grey };

/// "MJPEG", "YUYV", "UYVY", "GREY".
[[nodiscard]] const char* name_of(CaptureFormat format);
/// What the picture is called in ROS messages: "jpeg" (CompressedImage), "yuv422_yuy2", "yuv422", "mono8" (Image).
[[nodiscard]] const char* encoding_of(CaptureFormat format);
/// Reads a name in any case. Throws InputError naming `what`.
[[nodiscard]] CaptureFormat parse_capture_format(const std::string& text, const std::string& what);
/// Of V4L2's four-character code; none: of a format that is not taken.
[[nodiscard]] std::optional<CaptureFormat> capture_format_of(std::uint32_t fourcc);
/// 0 for MJPEG.
[[nodiscard]] std::size_t bytes_per_pixel(CaptureFormat format);

/// What a camera can do, or does.
struct CaptureMode {
  CaptureFormat format = CaptureFormat::mjpeg;
  std::uint32_t fourcc = 0;                                        ///< some drivers say JPEG where others say MJPG
  int width = 0, height = 0;                                       ///< 0: the driver does not tell
  std::uint32_t interval_numerator = 0, interval_denominator = 0;  ///< of the frame interval in seconds; 0: not told

  [[nodiscard]] double rate() const {
    return interval_numerator == 0 ? 0 : static_cast<double>(interval_denominator) / interval_numerator;
  }
  /// "MJPEG 1280x720 at 30 Hz".
  [[nodiscard]] std::string to_string() const;
};

/// What the user wants of a camera; what is not said is chosen.
struct CaptureWish {
  std::optional<CaptureFormat> format = {};
  int width = 0, height = 0;  ///< both or none
  double rate = 0;            ///< Hz
};

/// The mode that fits best. A format and a size that are wished for must be there: calibration holds for one size only.
/// A rate need not: the nearest that is not slower is taken, or else the fastest. Without a wish: the largest picture
/// of at most 1920 x 1080 pixels that comes at 25 Hz (or the wished rate) or more, or else the fastest mode; of equals,
/// formats in the order of CaptureFormat (MJPEG is passed on as it is and takes the least of a network). Throws
/// InputError naming `device`, with what there is.
[[nodiscard]] CaptureMode choose_mode(const std::vector<CaptureMode>& modes, const CaptureWish& wish,
                                      const std::string& device);

}  // namespace foreview
