#pragma once
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>

namespace foreview {

/// The largest picture that is decoded, pixels; what a header promises is checked before memory is spent on it.
inline constexpr std::int64_t kMostPicturePixels = 128'000'000;
inline constexpr std::size_t kMostPictureBytes = std::size_t{512} << 20;

/// Whether the bytes begin as a JPEG or PNG does.
[[nodiscard]] bool begins_as_picture(std::span<const unsigned char> bytes);

/// The size in a whole JPEG's or PNG's header. Its structure is walked to its end mark, nothing is decoded. Throws
/// InputError naming `where` on anything else.
[[nodiscard]] cv::Size whole_picture_size(std::span<const unsigned char> bytes, const std::string& where);

/// Decodes a JPEG or PNG in memory strictly, to CV_8UC3 BGR. The file's structure is walked to its end mark first (a
/// JPEG's segments to EOI, a PNG's chunks with their checksums to IEND), because OpenCV returns cut-off pictures with
/// a grey rest and no word. `expected`: the size the picture must have, else any up to kMostPicturePixels. Throws
/// InputError naming `where`.
[[nodiscard]] cv::Mat decode_picture(std::span<const unsigned char> bytes, const std::string& where,
                                     std::optional<cv::Size> expected = std::nullopt);

}  // namespace foreview
