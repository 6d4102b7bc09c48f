#include "foreview/viewer/staleness.h"

#include <gtest/gtest.h>

namespace foreview {
namespace {

using Level = Staleness::Level;

constexpr Timestamp at(double seconds) {
  return {static_cast<std::int64_t>(seconds * 1e9)};
}

StalenessInput seen(double now, double newest) {
  StalenessInput input;
  input.now = at(now);
  input.since = at(0);
  input.expected_delay = {500'000'000};
  input.newest_picture = at(newest);
  return input;
}

TEST(Staleness, FreshWithinTheDelay) {
  const Staleness staleness = assess_staleness(seen(10, 9.4));
  EXPECT_EQ(staleness.level, Level::fresh);
  EXPECT_EQ(staleness.severity, 0);
  EXPECT_EQ(staleness.text, "");
  EXPECT_NEAR(staleness.age.seconds(), 0.6, 1e-9);
}

TEST(Staleness, FromFreshThroughAgeingToStale) {
  double severity = 0;
  Level level = Level::fresh;
  for (int i = 0; i < 100; ++i) {
    const double age = 0.05 * i;
    const Staleness staleness = assess_staleness(seen(20, 20 - age));
    EXPECT_GE(staleness.severity, severity);
    EXPECT_GE(staleness.level, level);
    severity = staleness.severity;
    level = staleness.level;
    if (age < 1.45) {
      EXPECT_EQ(level, Level::fresh) << age;
    }
    if (age > 1.55 && age < 2.45) {
      EXPECT_EQ(level, Level::ageing) << age;
    }
    if (age > 2.55) {
      EXPECT_EQ(level, Level::stale) << age;
    }
    EXPECT_EQ(staleness.text.empty(), level < Level::stale) << "text says what the border says";
  }
  EXPECT_EQ(severity, 1);
}

TEST(Staleness, SaysWhatIsOldAndHowOld) {
  EXPECT_EQ(assess_staleness(seen(20, 15.8)).text, "STALE: newest picture 4.2 s old");
  StalenessInput input = seen(20, 19.8);
  input.poses_expected = true;
  input.newest_pose = at(17);
  EXPECT_EQ(assess_staleness(input).text, "STALE: newest camera pose 3.0 s old");
  input.state_expected = true;
  input.newest_state = at(16);
  EXPECT_EQ(assess_staleness(input).text, "STALE: newest robot state 4.0 s old");
  EXPECT_EQ(assess_staleness(input).age, Duration{4'000'000'000});
}

TEST(Staleness, WhatIsNotExpectedIsNotMissed) {
  StalenessInput input = seen(20, 19.8);
  EXPECT_EQ(assess_staleness(input).level, Level::fresh) << "no pose, state or link is given";
  input.pictures_expected = false;
  input.newest_picture.reset();
  EXPECT_EQ(assess_staleness(input).level, Level::fresh);
}

TEST(Staleness, WhatHasNeverComeIsMissedOnceItCouldHave) {
  StalenessInput input = seen(2.4, 0);
  input.newest_picture.reset();
  EXPECT_EQ(assess_staleness(input).level, Level::ageing);
  input.now = at(2.6);
  EXPECT_EQ(assess_staleness(input).level, Level::stale);
  EXPECT_EQ(assess_staleness(input).text, "STALE: no picture for 2.6 s");
}

TEST(Staleness, ASilentLinkIsTheWorst) {
  StalenessInput input = seen(20, 15.8);
  input.link_expected = true;
  input.last_heard = at(19.5);
  EXPECT_EQ(assess_staleness(input).level, Level::stale);
  input.last_heard = at(17.9);
  const Staleness silent = assess_staleness(input);
  EXPECT_EQ(silent.level, Level::silent);
  EXPECT_EQ(silent.text, "LINK SILENT for 2.1 s: newest picture 4.2 s old");
  input.newest_picture = at(19.9);
  EXPECT_GE(assess_staleness(input).severity, 0.5) << "even if what came last is young";
}

TEST(Staleness, LimitsAndClocks) {
  StalenessLimits limits;
  limits.beyond_delay = {100'000'000};
  EXPECT_EQ(assess_staleness(seen(20, 19.35), limits).level, Level::stale);
  limits.beyond_delay = {0};
  EXPECT_EQ(assess_staleness(seen(20, 19.35), limits).level, Level::stale);
  EXPECT_EQ(assess_staleness(seen(20, 19.51), limits).level, Level::fresh);
  const Staleness future = assess_staleness(seen(20, 25));
  EXPECT_EQ(future.level, Level::fresh);
  EXPECT_EQ(future.age, Duration{0});
}

}  // namespace
}  // namespace foreview
