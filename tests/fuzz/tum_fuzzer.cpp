#include <cmath>
#include <cstdint>

#include "foreview/recordings/tum_parsing.h"
#include "require.h"

// Picture lists and trajectories: whatever the bytes, what is returned is in order of time and usable.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  DamageLog damage;
  const std::vector<ListedPicture> pictures = parse_picture_list(text, "rgb.txt", damage);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    FUZZ_REQUIRE(stays_inside(pictures[i].file));
    FUZZ_REQUIRE(i == 0 || pictures[i - 1].stamp < pictures[i].stamp);
  }
  const Trajectory trajectory = parse_trajectory(text, "poses.txt", damage);
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Trajectory::Sample& sample = trajectory.samples()[i];
    FUZZ_REQUIRE(i == 0 || trajectory.samples()[i - 1].stamp < sample.stamp);
    FUZZ_REQUIRE(std::abs(glm::length(sample.pose.rotation) - 1) < 1e-9);
    FUZZ_REQUIRE(std::isfinite(sample.pose.translation.x + sample.pose.translation.y + sample.pose.translation.z));
  }
  if (!trajectory.empty()) {
    const Timestamp middle = trajectory.first() + Duration{(trajectory.last() - trajectory.first()).nanoseconds / 2};
    const std::optional<Pose> pose = trajectory.at(middle);
    FUZZ_REQUIRE(pose && std::abs(glm::length(pose->rotation) - 1) < 1e-9);
  }
  for (const char c : damage.summary()) FUZZ_REQUIRE(c != '\n');
  return 0;
}
