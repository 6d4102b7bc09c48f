#include <cmath>
#include <cstdint>

#include "foreview/recordings/joints_parsing.h"
#include "foreview/scene/errors.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  DamageLog damage;
  try {
    const Recording::Joints joints = parse_joints({reinterpret_cast<const char*>(data), size}, "joints.csv", damage);
    FUZZ_REQUIRE(!joints.names.empty() && joints.stamps.size() == joints.positions.size());
    for (std::size_t i = 0; i < joints.stamps.size(); ++i) {
      FUZZ_REQUIRE(i == 0 || joints.stamps[i - 1] < joints.stamps[i]);
      FUZZ_REQUIRE(joints.positions[i].size() == joints.names.size());
      for (const double position : joints.positions[i]) FUZZ_REQUIRE(std::isfinite(position));
    }
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
