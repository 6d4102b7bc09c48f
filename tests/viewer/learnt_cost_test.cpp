#include "foreview/viewer/learnt_cost.h"

#include <gtest/gtest.h>

#include <random>

namespace foreview {
namespace {

TEST(LearntCost, IsAsDeclaredUntilNearlyAllTheWindowSaysOtherwise) {
  LearntCost cost({});
  for (int i = 0; i < 30; ++i) {
    cost.observe(0.25);
    EXPECT_EQ(cost.high(), 1) << i;
  }
  cost.observe(0.25);
  EXPECT_EQ(cost.high(), 0.25);
}

TEST(LearntCost, RisesAtTheSecondLargerObservationAndFallsWhenTheWindowHasPassed) {
  LearntCost cost({});
  for (int i = 0; i < 32; ++i) {
    cost.observe(0.5);
  }
  cost.observe(3);
  EXPECT_EQ(cost.high(), 0.5) << "a single outlier";
  for (int i = 0; i < 10; ++i) {
    cost.observe(0.5);
  }
  cost.observe(2);
  EXPECT_EQ(cost.high(), 2) << "the second";
  for (int i = 0; i < 20; ++i) {
    cost.observe(0.5);
    EXPECT_EQ(cost.high(), 2);
  }
  cost.observe(0.5);
  EXPECT_EQ(cost.high(), 0.5) << "the first is 32 observations ago";
}

TEST(LearntCost, IsAHighQuantileOfWhatVaries) {
  LearntCost cost({});
  std::mt19937_64 engine(1);
  int exceeded = 0;
  double sum = 0;
  for (int i = 0; i < 20'032; ++i) {
    const double ratio = static_cast<double>(engine() >> 11) * 0x1p-53;
    if (i >= 32) {
      exceeded += ratio > cost.high() ? 1 : 0;
      sum += cost.high();
    }
    cost.observe(ratio);
  }
  // The second largest of 32 evenly spread lies at 31/33, and the next exceeds it in 2 of 33 cases.
  EXPECT_NEAR(exceeded / 20'000.0, 2 / 33.0, 0.006);
  EXPECT_NEAR(sum / 20'000, 31 / 33.0, 0.01);
}

TEST(LearntCost, LeavesOutWhatCannotBeAfforded) {
  LearntCost cost({.window = 8, .ignored = 1});
  for (const double ratio : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 5.0, 6.0}) {
    cost.observe(ratio);
  }
  EXPECT_EQ(cost.high(), 5);
  EXPECT_EQ(cost.high(4.9), 0.5);
  EXPECT_EQ(cost.high(0.6), 0.5);
  EXPECT_EQ(cost.median(), 0.5);
}

TEST(LearntCost, AFloorIsNeverUndercut) {
  LearntCost cost({.window = 32, .ignored = 1, .floor = 1});
  for (int i = 0; i < 64; ++i) {
    cost.observe(0.1);
  }
  EXPECT_EQ(cost.high(), 1);
  EXPECT_EQ(cost.median(), 1);
  cost.observe(2);
  cost.observe(2);
  EXPECT_EQ(cost.high(), 2);
}

}  // namespace
}  // namespace foreview
