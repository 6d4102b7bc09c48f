#include <cmath>
#include <cstdint>
#include <string>

#include "foreview/scene/errors.h"
#include "foreview/viewer/view_options_cli.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  try {
    const Pose pose = parse_pose({reinterpret_cast<const char*>(data), size}, "--camera-pose");
    FUZZ_REQUIRE(std::abs(glm::length(pose.rotation) - 1) < 1e-9);
    const Pose again = parse_pose(to_text(pose), "--camera-pose");
    FUZZ_REQUIRE(again.translation == pose.translation && angle_between(again, pose) < 1e-9);
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
