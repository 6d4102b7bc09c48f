#include "foreview/recordings/picture_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

using Bytes = std::span<const unsigned char>;

constexpr std::array<unsigned char, 8> kPngSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

[[noreturn]] void fail_cut_off(const std::string& where, const char* kind) {
  throw InputError(where, std::string("is a ") + kind + " that is cut off");
}

/// Size in the header of a whole JPEG; ITU T.81, annex B.
cv::Size walk_jpeg(Bytes bytes, const std::string& where) {
  constexpr int kMostScans = 100;  // progressive files have about 10; thousands are made to keep decoders busy
  cv::Size size;
  int scans = 0;
  std::size_t at = 2;
  while (true) {
    if (at + 2 > bytes.size()) fail_cut_off(where, "JPEG");
    if (bytes[at] != 0xff) throw InputError(where, "is a damaged JPEG: no marker where one must be");
    const unsigned marker = bytes[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    at += 2;
    if (marker == 0xd9) break;
    if (marker == 0x01) continue;
    if (marker == 0x00 || (marker >= 0xd0 && marker <= 0xd8)) {
      throw InputError(where, "is a damaged JPEG: marker out of place");
    }
    if (at + 2 > bytes.size()) fail_cut_off(where, "JPEG");
    const std::size_t length = big_endian(bytes, at, 2);
    if (length < 2) throw InputError(where, "is a damaged JPEG: segment without length");
    if (at + length > bytes.size()) fail_cut_off(where, "JPEG");
    const bool is_frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      if (length < 8 || !size.empty()) throw InputError(where, "is a damaged JPEG: bad frame header");
      size = cv::Size(static_cast<int>(big_endian(bytes, at + 5, 2)), static_cast<int>(big_endian(bytes, at + 3, 2)));
    }
    at += length;
    if (marker != 0xda) continue;
    if (++scans > kMostScans) throw InputError(where, "is a JPEG of more than 100 scans");
    // Coded data: up to the next marker that is neither a stuffed zero nor a restart.
    while (at + 1 < bytes.size() &&
           !(bytes[at] == 0xff && bytes[at + 1] != 0x00 && (bytes[at + 1] < 0xd0 || bytes[at + 1] > 0xd7))) {
      ++at;
    }
  }
  if (scans == 0 || size.empty()) throw InputError(where, "is a JPEG without a picture");
  return size;
}

std::uint32_t crc32(Bytes bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> result{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      std::uint32_t c = n;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? 0xedb88320U ^ (c >> 1) : c >> 1;
      result[n] = c;
    }
    return result;
  }();
  std::uint32_t c = 0xffffffffU;
  for (const unsigned char byte : bytes) c = table[(c ^ byte) & 0xff] ^ (c >> 8);
  return ~c;
}

/// Size in the header of a whole PNG; ISO/IEC 15948, clause 5.
cv::Size walk_png(Bytes bytes, const std::string& where) {
  constexpr std::size_t kAround = 12;  // length, type and checksum of a chunk
  cv::Size size;
  bool has_data = false;
  std::size_t at = kPngSignature.size();
  while (true) {
    if (bytes.size() - at < kAround) fail_cut_off(where, "PNG");
    const std::size_t length = big_endian(bytes, at, 4);
    if (bytes.size() - at - kAround < length) fail_cut_off(where, "PNG");
    const std::uint32_t type = big_endian(bytes, at + 4, 4);
    if (crc32(bytes.subspan(at + 4, length + 4)) != big_endian(bytes, at + 8 + length, 4)) {
      throw InputError(where, "is a damaged PNG: wrong checksum");
    }
    constexpr std::uint32_t kHeader = 0x49484452, kData = 0x49444154, kEnd = 0x49454e44;
    if ((type == kHeader) != (at == kPngSignature.size()) || (type == kHeader && length != 13)) {
      throw InputError(where, "is a damaged PNG: bad header");
    }
    if (type == kHeader) {
      constexpr std::uint32_t kLargest = 0x7fffffff;
      const std::uint32_t width = big_endian(bytes, at + 8, 4), height = big_endian(bytes, at + 12, 4);
      if (width == 0 || height == 0 || width > kLargest || height > kLargest) {
        throw InputError(where, "is a damaged PNG: impossible size");
      }
      size = cv::Size(static_cast<int>(width), static_cast<int>(height));
    }
    has_data = has_data || type == kData;
    if (type == kEnd) break;
    at += length + kAround;
  }
  if (!has_data) throw InputError(where, "is a PNG without a picture");
  return size;
}

std::string text_of(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

bool is_jpeg(Bytes bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

bool is_png(Bytes bytes) {
  return bytes.size() >= kPngSignature.size() && std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin());
}

}  // namespace

bool begins_as_picture(Bytes bytes) {
  return is_jpeg(bytes) || is_png(bytes);
}

cv::Size whole_picture_size(Bytes bytes, const std::string& where) {
  if (bytes.empty()) throw InputError(where, "is empty; expected a JPEG or PNG picture");
  if (is_jpeg(bytes)) return walk_jpeg(bytes, where);
  if (is_png(bytes)) return walk_png(bytes, where);
  throw InputError(where, "is neither a JPEG nor a PNG picture");
}

cv::Mat decode_picture(Bytes bytes, const std::string& where, std::optional<cv::Size> expected) {
  const cv::Size size = whole_picture_size(bytes, where);
  const auto fail_size = [&](const cv::Size& found) {
    throw InputError(where, "is " + text_of(found) + " pixels; expected " + text_of(*expected) + " as in camera.yaml");
  };
  // EXIF may turn the picture by a right angle after this header was read.
  if (expected && size != *expected && cv::Size(size.height, size.width) != *expected) fail_size(size);
  if (std::int64_t{size.width} * size.height > kMostPicturePixels) {
    throw InputError(where, "is " + text_of(size) + " pixels; more than are accepted");
  }
  cv::Mat picture;
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<unsigned char*>(bytes.data()));
    picture = cv::imdecode(buffer, cv::IMREAD_COLOR);
  } catch (const cv::Exception& error) {
    throw InputError(where, "cannot be decoded: " + in_quotes(error.err));
  }
  if (picture.empty() || picture.type() != CV_8UC3) throw InputError(where, "cannot be decoded");
  if (expected && picture.size() != *expected) fail_size(picture.size());
  return picture;
}

cv::Mat read_picture_file(const std::filesystem::path& file) {
  const std::string bytes = read_input_file(file, kMostPictureBytes);
  return decode_picture({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, file.string());
}

}  // namespace foreview
