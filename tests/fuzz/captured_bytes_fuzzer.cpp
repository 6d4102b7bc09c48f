#include <algorithm>
#include <cstdint>
#include <vector>

#include "foreview/recordings/picture_file.h"
#include "foreview/scene/errors.h"
#include "foreview/server/capture/captured_bytes.h"
#include "require.h"

namespace {

using namespace foreview;
using Bytes = std::span<const unsigned char>;

void check_raw(const VideoFormat& format, Bytes bytes, const std::vector<unsigned char>& picture) {
  const std::size_t row = static_cast<std::size_t>(format.mode.width) * bytes_per_pixel(format.mode.format);
  FUZZ_REQUIRE(picture.size() == row * static_cast<std::size_t>(format.mode.height));
  for (std::size_t i = 0; i < picture.size(); ++i) {
    FUZZ_REQUIRE(picture[i] == bytes[i / row * format.bytes_per_line + i % row]);
  }
}

void check_jpeg(const VideoFormat& format, Bytes bytes, const std::vector<unsigned char>& picture) {
  FUZZ_REQUIRE(picture.size() <= bytes.size() + 420 && picture.size() >= 4);
  FUZZ_REQUIRE(picture[0] == 0xff && picture[1] == 0xd8);
  FUZZ_REQUIRE(picture[picture.size() - 2] == 0xff && picture.back() == 0xd9);
  // What was repaired needs no repair.
  std::vector<unsigned char> again;
  FUZZ_REQUIRE(read_captured(format, picture, again) == CaptureFault::none && again == picture);
  try {
    const cv::Mat decoded = decode_picture(picture, "picture");
    FUZZ_REQUIRE(!decoded.empty());
  } catch (const InputError&) {
  }
}

}  // namespace

// Of a driver's bytes a picture of the agreed size comes out, or a fault. The first bytes choose the format.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 5) return 0;
  VideoFormat format;
  format.mode.format = static_cast<CaptureFormat>(data[0] % 4);
  format.mode.width = data[1] + 1;
  format.mode.height = data[2] + 1;
  const std::size_t row = static_cast<std::size_t>(format.mode.width) * bytes_per_pixel(format.mode.format);
  format.bytes_per_line = row + data[3];
  format.size_image = format.bytes_per_line * static_cast<std::size_t>(format.mode.height) + data[4];
  const Bytes bytes(data + 5, size - 5);
  std::vector<unsigned char> picture;
  if (read_captured(format, bytes, picture) != CaptureFault::none) return 0;
  if (format.mode.format == CaptureFormat::mjpeg) {
    check_jpeg(format, bytes, picture);
  } else {
    check_raw(format, bytes, picture);
  }
  return 0;
}
