#include "foreview/recordings/tum_parsing.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "log_capture.h"

namespace foreview {
namespace {

TEST(PictureList, ReadsCommentsBlanksTabsCrlfAndNamesWithSpaces) {
  DamageLog damage;
  const auto pictures = parse_picture_list(
      "\xEF\xBB\xBF# color images\r\n\r\n   \t\n1305031102.175304123\trgb/1.png\r\n  1305031103  my pictures/2 b.jpg  "
      "\n#x",
      "rgb.txt", damage);
  ASSERT_EQ(pictures.size(), 2U);
  EXPECT_EQ(pictures[0].stamp.nanoseconds, 1305031102175304123);
  EXPECT_EQ(pictures[0].file, "rgb/1.png");
  EXPECT_EQ(pictures[0].line, 4U);
  EXPECT_EQ(pictures[1].stamp.nanoseconds, 1305031103000000000);
  EXPECT_EQ(pictures[1].file, "my pictures/2 b.jpg");
  EXPECT_EQ(damage.counts().total(), 0U);
}

TEST(PictureList, DropsAndCountsMalformedLines) {
  DamageLog damage;
  const auto pictures = parse_picture_list(
      "1 a.png\n"
      "nan b.png\n"
      "x b.png\n"
      "2\n"
      "3 /etc/passwd\n"
      "4 ../other/b.png\n"
      "5 rgb/../../b.png\n"
      "1e300 b.png\n"
      "-5e9 b.png\n" +
          std::string("6 b\0.png\n", 9) + "7 " + std::string(5000, 'a') + "\n8 z.png",
      "rgb.txt", damage);
  ASSERT_EQ(pictures.size(), 2U);
  EXPECT_EQ(pictures[1].file, "z.png");
  EXPECT_EQ(damage.counts().lines_malformed, 10U);
  EXPECT_EQ(damage.counts().total(), 10U);
  EXPECT_NE(damage.summary().find("rgb.txt:2: 'nan'"), std::string::npos) << damage.summary();
}

TEST(PictureList, SortsAndKeepsTheFirstOfEqualStamps) {
  DamageLog damage;
  const auto pictures = parse_picture_list("1 a\n3 c\n2 b\n3 again\n2.5 d\n1 again\n4 e\n", "rgb.txt", damage);
  std::string order;
  for (const ListedPicture& picture : pictures) order += picture.file;
  EXPECT_EQ(order, "abdce");
  EXPECT_EQ(damage.counts().stamps_out_of_order, 3U);  // b, d and the second 1
  EXPECT_EQ(damage.counts().stamps_duplicated, 2U);
  EXPECT_EQ(damage.counts().total(), 5U);
}

TEST(TrajectoryText, ReadsPosesAndNormalisesAlmostUnitQuaternions) {
  DamageLog damage;
  const Trajectory trajectory =
      parse_trajectory("# t\n0 1 2 3 0 0 0.6 0.8\r\n1\t+1 -2 3e0 0.0 0 0.603 0.804 # note\n", "poses", damage);
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(damage.counts().total(), 0U);
  const Pose first = trajectory.samples()[0].pose, second = trajectory.samples()[1].pose;
  EXPECT_EQ(first.translation, glm::dvec3(1, 2, 3));
  EXPECT_DOUBLE_EQ(first.rotation.z, 0.6);
  EXPECT_DOUBLE_EQ(first.rotation.w, 0.8);
  EXPECT_EQ(second.translation, glm::dvec3(1, -2, 3));
  EXPECT_DOUBLE_EQ(second.rotation.z, 0.6);
  EXPECT_DOUBLE_EQ(second.rotation.w, 0.8);
}

TEST(TrajectoryText, DropsAndCountsDamagedPosesByKind) {
  DamageLog damage;
  const Trajectory trajectory = parse_trajectory(
      "0 0 0 0 0 0 0 1\n"
      "1 nan 0 0 0 0 0 1\n"
      "2 0 inf 0 0 0 0 1\n"
      "3 0 0 0 0 0 0 nan\n"
      "4 2e9 0 0 0 0 0 1\n"
      "5 0 0 0 0 0 0 0\n"
      "6 0 0 0 0 0 0 1.02\n"
      "7 0 0 0 1 1 1 1\n"
      "8 0 0 0 0 0 0\n"
      "9 0 0 0 0 0 0 1 5\n"
      "10 0 0 zero 0 0 0 1\n"
      "11,0,0,0,0,0,0,1\n"
      "NaN 0 0 0 0 0 0 1\n"
      "12 0 0 0 0 0 0 1.009\n"
      "0 9 9 9 0 0 0 1\n",
      "poses", damage);
  EXPECT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory.samples()[0].pose.translation, glm::dvec3(0));  // the first of equal stamps
  EXPECT_EQ(damage.counts().poses_not_finite, 4U);
  EXPECT_EQ(damage.counts().poses_not_unit, 3U);
  EXPECT_EQ(damage.counts().lines_malformed, 5U);
  EXPECT_EQ(damage.counts().stamps_out_of_order, 1U);
  EXPECT_EQ(damage.counts().stamps_duplicated, 1U);
  EXPECT_EQ(damage.counts().total(), 14U);

  const test::LogCapture log;
  damage.report("sample");
  EXPECT_EQ(log.lines(), 5) << log.text();
  EXPECT_NE(log.text().find("sample: 4 poses dropped, not finite; first poses:2: "), std::string::npos) << log.text();
}

TEST(TrajectoryText, DropsBinaryGarbage) {
  std::string garbage;
  std::uint32_t state = 1;
  for (int i = 0; i < 20000; ++i) {
    state = state * 1664525U + 1013904223U;
    garbage += static_cast<char>(state >> 24);
  }
  DamageLog damage;
  EXPECT_TRUE(parse_trajectory(garbage, "poses", damage).empty());
  EXPECT_TRUE(parse_picture_list(garbage, "rgb.txt", damage).empty());
  EXPECT_GT(damage.counts().lines_malformed, 100U);
  for (const char c : damage.summary()) EXPECT_TRUE(c >= 0x20 && c < 0x7f);
}

// Backwards in time is the slowest order for sorted insertion.
TEST(TrajectoryText, ReadsAHundredThousandLinesWrittenBackwards) {
  std::string text;
  for (int i = 100000; i > 0; --i) text += std::to_string(i) + ".5 0.1 0.2 0.3 0 0 0 1\n";
  DamageLog damage;
  const Trajectory trajectory = parse_trajectory(text, "poses", damage);
  EXPECT_EQ(trajectory.size(), 100000U);
  EXPECT_EQ(trajectory.first().nanoseconds, 1500000000);
  EXPECT_EQ(damage.counts().stamps_out_of_order, 99999U);
}

TEST(Trajectory, InterpolatesBetweenAndNeverExtrapolates) {
  DamageLog damage;
  const Trajectory trajectory =
      parse_trajectory("1 0 0 0 0 0 0 1\n2 4 0 0 0 0 1 0\n4 4 8 0 0 0 1 0\n", "poses", damage);
  const auto at = [&](double seconds) { return trajectory.at(Timestamp::from_seconds(seconds)); };
  EXPECT_FALSE(trajectory.at({999'999'999}));
  EXPECT_FALSE(trajectory.at({4'000'000'001}));
  ASSERT_TRUE(at(1) && at(1.25) && at(3) && at(4));
  EXPECT_NEAR(at(1.25)->translation.x, 1, 1e-12);
  EXPECT_NEAR(angle_between(*at(1), *at(1.25)), std::acos(-1) / 4, 1e-9);
  EXPECT_NEAR(at(3)->translation.y, 4, 1e-12);
  EXPECT_EQ(at(4)->translation, glm::dvec3(4, 8, 0));
  EXPECT_FALSE(Trajectory().at({0}));
}

TEST(StaysInside, RefusesWhatLeadsOut) {
  for (const char* path : {"a", "a/b", "./a", "a..b/..c", ".hidden"}) EXPECT_TRUE(stays_inside(path)) << path;
  for (const char* path : {"", "/", "/a", "..", "../a", "a/../../b", "a/.."}) EXPECT_FALSE(stays_inside(path)) << path;
}

}  // namespace
}  // namespace foreview
