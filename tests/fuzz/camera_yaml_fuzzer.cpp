#include <cstdint>
#include <string>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/errors.h"
#include "require.h"

// A camera that is accepted is possible, and survives being written and read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  CameraModel camera;
  try {
    camera = parse_camera_yaml(std::string(reinterpret_cast<const char*>(data), size), "camera.yaml");
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
    return 0;
  }
  FUZZ_REQUIRE(camera.width >= 1 && camera.width <= 16384 && camera.height >= 1 && camera.height <= 16384);
  FUZZ_REQUIRE(camera.focal_length.x > 0 && camera.focal_length.y > 0);
  const CameraModel again = parse_camera_yaml(to_camera_yaml(camera), "written");
  FUZZ_REQUIRE(again.focal_length == camera.focal_length && again.distortion == camera.distortion);
  FUZZ_REQUIRE(again.distortion_model == camera.distortion_model && again.name == camera.name);
  return 0;
}
