#include "foreview/server/encoded_picture.h"

#include <array>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>

#include "foreview/recordings/picture_file.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

struct Encoding {
  std::string_view name;
  int bytes_per_pixel;
  int type;
  std::optional<int> to_bgr;  ///< OpenCV's conversion
};
constexpr std::array<Encoding, 12> kEncodings{{
    {"mono8", 1, CV_8UC1, cv::COLOR_GRAY2BGR},
    {"8UC1", 1, CV_8UC1, cv::COLOR_GRAY2BGR},
    {"rgb8", 3, CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgr8", 3, CV_8UC3, std::nullopt},
    {"8UC3", 3, CV_8UC3, std::nullopt},
    {"rgba8", 4, CV_8UC4, cv::COLOR_RGBA2BGR},
    {"bgra8", 4, CV_8UC4, cv::COLOR_BGRA2BGR},
    {"yuv422", 2, CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"uyvy", 2, CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", 2, CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"yuyv", 2, CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"yuv422_yuyv", 2, CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
}};

const Encoding* encoding_of(const ImageMessage& image) {
  for (const Encoding& known : kEncodings) {
    if (image.encoding == known.name) return &known;
  }
  return nullptr;
}

std::size_t row_bytes(const ImageMessage& image, const Encoding& encoding) {
  return std::size_t{image.width} * static_cast<std::size_t>(encoding.bytes_per_pixel);
}

/// The last row may come without its padding.
bool has_all_rows(const ImageMessage& image, std::size_t row, std::size_t step) {
  return row > 0 && image.height > 0 && step >= row && image.data.size() >= row &&
         (image.data.size() - row) / step >= std::size_t{image.height} - 1;
}

cv::Mat decode_raw(const ImageMessage& image, const std::string& where, cv::Size expected) {
  const Encoding* const encoding = encoding_of(image);
  if (encoding == nullptr) {
    throw InputError(where, "encoding " + in_quotes(image.encoding.substr(0, 40)) +
                                " is not known; expected mono8, rgb8, bgr8, rgba8, bgra8, yuv422 or yuv422_yuy2");
  }
  if (image.width != static_cast<std::uint32_t>(expected.width) ||
      image.height != static_cast<std::uint32_t>(expected.height)) {
    throw InputError(where, "is " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                " pixels; expected " + std::to_string(expected.width) + "x" +
                                std::to_string(expected.height) + " as in camera_info");
  }
  const std::size_t row = row_bytes(image, *encoding);
  const std::size_t step = image.step == 0 ? row : image.step;
  if (!has_all_rows(image, row, step)) {
    throw InputError(where, "is cut off: " + std::to_string(image.data.size()) + " bytes in rows of " +
                                std::to_string(step) + "; expected " + std::to_string(image.height) + " rows");
  }
  if (encoding->type == CV_8UC2 && image.width % 2 != 0) {
    throw InputError(where, "is of odd width, which " + image.encoding + " cannot be");
  }
  const cv::Mat raw(expected, encoding->type, const_cast<std::uint8_t*>(image.data.data()), step);
  cv::Mat picture;
  if (encoding->to_bgr) {
    cv::cvtColor(raw, picture, *encoding->to_bgr);
  } else {
    raw.copyTo(picture);
  }
  return picture;
}

}  // namespace

const MessageHeader& header_of(const EncodedPicture& picture) {
  return std::visit([](const auto& message) -> const MessageHeader& { return message.header; }, picture);
}

std::size_t bytes_of(const EncodedPicture& picture) {
  return std::visit([](const auto& message) { return message.data.size(); }, picture);
}

bool looks_like_picture(const EncodedPicture& picture) {
  const auto* raw = std::get_if<ImageMessage>(&picture);
  if (raw == nullptr) return begins_as_picture(std::get<CompressedImageMessage>(picture).data);
  const Encoding* const encoding = encoding_of(*raw);
  if (encoding == nullptr) return false;
  const std::size_t row = row_bytes(*raw, *encoding);
  return has_all_rows(*raw, row, raw->step == 0 ? row : raw->step);
}

bool looks_whole(const EncodedPicture& picture) {
  const auto* compressed = std::get_if<CompressedImageMessage>(&picture);
  if (compressed == nullptr) return looks_like_picture(picture);
  try {
    return !whole_picture_size(compressed->data, "picture").empty();
  } catch (const InputError&) {
    return false;
  }
}

cv::Mat decode(const EncodedPicture& picture, const std::string& where, cv::Size expected) {
  if (const auto* raw = std::get_if<ImageMessage>(&picture)) return decode_raw(*raw, where, expected);
  const auto& compressed = std::get<CompressedImageMessage>(picture);
  if (compressed.data.size() > kMostPictureBytes) throw InputError(where, "is larger than any picture");
  return decode_picture(compressed.data, where, expected);
}

}  // namespace foreview
