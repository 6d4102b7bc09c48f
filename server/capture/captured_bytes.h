#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "foreview/server/capture/capture_format.h"

namespace foreview {

/// What a camera has agreed to deliver.
struct VideoFormat {
  CaptureMode mode = {};
  std::size_t bytes_per_line = 0;  ///< raw formats; at least width * bytes per pixel
  std::size_t size_image = 0;      ///< the most bytes of a picture
};

/// Of a whole raw picture, whose last line need not be padded; 0 for MJPEG.
[[nodiscard]] std::size_t least_bytes(const VideoFormat& format);

enum class CaptureFault : std::uint8_t {
  none,
  short_frame,  ///< ends before the picture does
  wrong_size,   ///< of another size than agreed
  damaged,      ///< no JPEG, or not a whole one
};

/// Makes of a driver's buffer what is passed on; `picture` is overwritten, and void unless none is returned.
///  - Raw: rows without padding.
///  - MJPEG: the JPEG's structure is walked from mark to mark up to its end (ITU T.81, annex B); what cameras append
///  after
///    it is cut off. Many leave out the Huffman tables, as AVI does: the standard ones (annex K.3) are put in, so that
///    every JPEG decoder reads it. Coded data is not looked at.
/// Any bytes may come in.
[[nodiscard]] CaptureFault read_captured(const VideoFormat& format, std::span<const unsigned char> bytes,
                                         std::vector<unsigned char>& picture);

}  // namespace foreview
