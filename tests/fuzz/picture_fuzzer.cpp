#include <cstdint>

#include "foreview/recordings/picture_file.h"
#include "foreview/scene/errors.h"
#include "require.h"

// A picture of at most the expected size comes out, or an InputError; OpenCV's decoders are in reach of every byte.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  if (size < 2) return 0;
  const cv::Size expected(data[0] + 1, data[1] + 1);
  try {
    const cv::Mat picture = decode_picture({data + 2, size - 2}, "picture", expected);
    FUZZ_REQUIRE(picture.size() == expected && picture.type() == CV_8UC3);
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
