#pragma once
#include <opencv2/core/mat.hpp>
#include <string>
#include <variant>

#include "foreview/server/dds/messages.h"

namespace foreview {

/// A picture as it came.
using EncodedPicture = std::variant<CompressedImageMessage, ImageMessage>;

[[nodiscard]] const MessageHeader& header_of(const EncodedPicture& picture);
[[nodiscard]] std::size_t bytes_of(const EncodedPicture& picture);

/// Whether it can be a picture at all, by its first bytes (raw: by its encoding and sizes): costs nothing.
[[nodiscard]] bool looks_like_picture(const EncodedPicture& picture);
/// Whether nothing of it is missing, by its structure; it may still be refused by decode(). Reads it once.
[[nodiscard]] bool looks_whole(const EncodedPicture& picture);

/// To CV_8UC3 BGR. Compressed: a whole JPEG or PNG. Raw: mono8, rgb8, bgr8, rgba8, bgra8, yuv422 (UYVY) and
/// yuv422_yuy2 (YUYV), of rows of `step` bytes. Throws InputError at `where` on anything else, on pictures that are cut
/// off, and on another size than `expected`.
[[nodiscard]] cv::Mat decode(const EncodedPicture& picture, const std::string& where, cv::Size expected);

}  // namespace foreview
