#include <array>
#include <cstdint>
#include <cstring>

#include "foreview/scene/errors.h"
#include "foreview/server/encoded_picture.h"
#include "require.h"

// A raw message with any sizes over any bytes: a picture of the expected size comes out, or an InputError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  constexpr std::array kEncodings{"mono8", "rgb8",        "bgr8", "rgba8",  "bgra8",       "yuv422",
                                  "uyvy",  "yuv422_yuy2", "yuyv", "mono16", "bayer_rggb8", ""};
  if (size < 16) return 0;
  ImageMessage image;
  std::memcpy(&image.width, data, 4);
  std::memcpy(&image.height, data + 4, 4);
  std::memcpy(&image.step, data + 8, 4);
  image.encoding = kEncodings[data[12] % kEncodings.size()];
  const cv::Size expected(data[13] + 1, data[14] + 1);
  // Mostly as expected, or little but the first check would be tried.
  if (data[15] % 4 != 0) {
    image.width = static_cast<std::uint32_t>(expected.width);
    image.height = static_cast<std::uint32_t>(expected.height);
    if (data[15] % 4 == 1) image.step %= 1024;
  }
  image.data.assign(data + 16, data + size);
  if (data[15] % 8 == 7) image.data.resize(size * 97);
  const bool looks = looks_like_picture(image);
  try {
    const cv::Mat picture = decode(image, "topic", expected);
    FUZZ_REQUIRE(picture.size() == expected && picture.type() == CV_8UC3);
    FUZZ_REQUIRE(looks);
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
