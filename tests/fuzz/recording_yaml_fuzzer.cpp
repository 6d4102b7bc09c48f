#include <cstdint>

#include "foreview/recordings/recording_yaml.h"
#include "foreview/recordings/tum_parsing.h"
#include "foreview/scene/errors.h"
#include "require.h"

// A recording.yaml that is accepted leads nowhere outside, and survives being written and read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  RecordingYaml yaml;
  try {
    yaml = parse_recording_yaml(std::string(reinterpret_cast<const char*>(data), size), "recording.yaml");
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
    return 0;
  }
  for (const std::string& camera : yaml.cameras) FUZZ_REQUIRE(is_plain_file_name(camera) && stays_inside(camera));
  FUZZ_REQUIRE(!yaml.scene_file || stays_inside(*yaml.scene_file));
  FUZZ_REQUIRE(!yaml.initial_textures || stays_inside(*yaml.initial_textures));
  FUZZ_REQUIRE(yaml.import_options.scale > 0);
  const std::string written = to_recording_yaml(yaml);
  FUZZ_REQUIRE(to_recording_yaml(parse_recording_yaml(written, "written")) == written);
  return 0;
}
