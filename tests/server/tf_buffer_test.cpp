#include "foreview/server/tf_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace foreview {
namespace {

constexpr Timestamp at_ms(std::int64_t count) {
  return {count * 1'000'000};
}
Pose shifted(double x) {
  return {{1, 0, 0, 0}, {x, 0, 0}};
}
Pose random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {glm::normalize(glm::dquat(normal(random), normal(random), normal(random), normal(random))),
          {normal(random), normal(random), normal(random)}};
}
void expect_near(const std::optional<Pose>& a, const Pose& b) {
  ASSERT_TRUE(a);
  EXPECT_LT(glm::length(a->translation - b.translation), 1e-9);
  EXPECT_LT(angle_between(*a, b), 1e-7);
}

TEST(TfBuffer, InterpolatesBetweenStampsAndNeverBeyond) {
  TfBuffer tf;
  EXPECT_TRUE(tf.add("world", "camera", at_ms(100), shifted(1)));
  EXPECT_TRUE(tf.add("world", "camera", at_ms(300), shifted(3)));
  EXPECT_TRUE(tf.add("world", "camera", at_ms(200), shifted(5)));  // late
  EXPECT_DOUBLE_EQ(tf.at("world", "camera", at_ms(150))->translation.x, 3);
  EXPECT_DOUBLE_EQ(tf.at("world", "camera", at_ms(250))->translation.x, 4);
  EXPECT_EQ(tf.at("world", "camera", at_ms(300)), shifted(3));
  EXPECT_FALSE(tf.at("world", "camera", at_ms(99)));
  EXPECT_FALSE(tf.at("world", "camera", at_ms(301)));
  EXPECT_EQ(tf.newest("world", "camera", at_ms(999)), at_ms(300));
}

TEST(TfBuffer, FollowsChainsOfMovingAndStaticFrames) {
  std::mt19937 random(3);
  const Pose world_from_base = random_pose(random), base_from_arm = random_pose(random),
             arm_from_camera = random_pose(random), base_from_tool = random_pose(random);
  TfBuffer tf;
  tf.add("/world", "base", at_ms(0), world_from_base);
  tf.add("world", "base", at_ms(100), world_from_base);
  tf.add("base", "arm", at_ms(0), base_from_arm);
  tf.add("base", "arm", at_ms(80), base_from_arm);
  tf.add("arm", "camera", at_ms(5000), arm_from_camera, true);  // static: at any time
  tf.add("base", "tool", {}, base_from_tool, true);
  expect_near(tf.at("world", "camera", at_ms(50)), world_from_base * base_from_arm * arm_from_camera);
  expect_near(tf.at("camera", "world", at_ms(50)), (world_from_base * base_from_arm * arm_from_camera).inverse());
  expect_near(tf.at("tool", "camera", at_ms(50)), base_from_tool.inverse() * base_from_arm * arm_from_camera);
  expect_near(tf.at("arm", "arm", at_ms(50)), Pose());
  EXPECT_EQ(tf.newest("world", "camera", at_ms(999)), at_ms(80));
  // What moves above the frame where the two ways meet does not matter.
  EXPECT_TRUE(tf.at("base", "tool", at_ms(7777)));
  EXPECT_EQ(tf.newest("base", "tool", at_ms(999)), at_ms(999));
  EXPECT_FALSE(tf.at("world", "elsewhere", at_ms(50)));
  EXPECT_FALSE(tf.newest("world", "elsewhere", at_ms(50)));
}

TEST(TfBuffer, SurvivesCirclesAndNewParents) {
  TfBuffer tf;
  tf.add("b", "a", at_ms(0), shifted(1));
  tf.add("a", "b", at_ms(0), shifted(1));
  EXPECT_FALSE(tf.at("world", "a", at_ms(0)));
  EXPECT_FALSE(tf.add("a", "a", at_ms(0), shifted(1)));
  tf.add("world", "b", at_ms(10), shifted(7));
  EXPECT_FALSE(tf.at("world", "b", at_ms(5)));  // was in another parent then
  EXPECT_EQ(tf.at("world", "b", at_ms(10)), shifted(7));
}

TEST(TfBuffer, RefusesWhatIsNoPose) {
  TfBuffer tf;
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(tf.add("w", "a", {}, {{1, 0, 0, 0}, {nan, 0, 0}}));
  EXPECT_FALSE(tf.add("w", "a", {}, {{1, 0, 0, 0}, {0, infinite, 0}}));
  EXPECT_FALSE(tf.add("w", "a", {}, {{0, 0, 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(tf.add("w", "a", {}, {{nan, 0, 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(tf.add("w", "a", {}, {{1.02, 0, 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(tf.add("", "a", {}, Pose()));
  EXPECT_FALSE(tf.add("w", "", {}, Pose()));
  EXPECT_EQ(tf.frames(), 0U);
  EXPECT_TRUE(tf.add("w", "a", {}, {{1.005, 0, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(tf.at("w", "a", {}), Pose());
  EXPECT_FALSE(tf.add("w", "a", {}, shifted(2)));  // the first stays
}

TEST(TfBuffer, MemoryIsBounded) {
  TfBuffer tf({.memory = {1'000'000'000}, .most_frames = 10, .most_samples = 50});
  for (int i = 0; i < 1000; ++i) {
    tf.add("w", "slow", at_ms(100 * i), shifted(i));
    tf.add("w", "fast", at_ms(i), shifted(i));
    tf.add("w", "frame" + std::to_string(i), at_ms(0), Pose());
  }
  EXPECT_EQ(tf.frames(), 10U);
  EXPECT_LE(tf.samples(), 8 + 50 + 12U);
  EXPECT_TRUE(tf.at("w", "slow", at_ms(99900 - 1000)));
  EXPECT_FALSE(tf.at("w", "slow", at_ms(99900 - 1200)));
  EXPECT_FALSE(tf.add("w", "slow", at_ms(99900 - 1001), shifted(1)));
  tf.add("w", "fixed", {}, Pose(), true);
  tf.clear_moving();
  EXPECT_EQ(tf.frames(), 0U);  // ten frames were there before "fixed" came
}

}  // namespace
}  // namespace foreview
