#include "foreview/gpu/batched/slice_cursor.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace foreview::batched {
namespace {

TEST(SliceCursor, TakesWhatFitsPassByPass) {
  SliceCursor cursor(
      {{ExtractionStep::upload, 3, 2.0}, {ExtractionStep::other, 0, 1.0}, {ExtractionStep::filling, 2, 5.0}});
  EXPECT_DOUBLE_EQ(cursor.left(), 16);
  EXPECT_DOUBLE_EQ(cursor.least(), 2);
  EXPECT_FALSE(cursor.take(1.9, false));
  auto piece = cursor.take(1.9, true);
  ASSERT_TRUE(piece);
  EXPECT_EQ(piece->pass, 0U);
  EXPECT_EQ(piece->run.first, 0U);
  EXPECT_EQ(piece->run.count, 1U);
  EXPECT_DOUBLE_EQ(piece->size, 2);
  piece = cursor.take(100, true);
  ASSERT_TRUE(piece);
  EXPECT_EQ(piece->pass, 0U);
  EXPECT_EQ(piece->run.first, 1U);
  EXPECT_EQ(piece->run.count, 2U);
  // The pass without units is passed over.
  EXPECT_EQ(cursor.present().step, ExtractionStep::filling);
  EXPECT_DOUBLE_EQ(cursor.left(), 10);
  piece = cursor.take(-1, true);
  EXPECT_EQ(piece->pass, 2U);
  EXPECT_FALSE(cursor.is_at_end());
  piece = cursor.take(std::numeric_limits<double>::max(), true);
  EXPECT_EQ(piece->run.count, 1U);
  EXPECT_TRUE(cursor.is_at_end());
  EXPECT_DOUBLE_EQ(cursor.left(), 0);
}

TEST(SliceCursor, GivesAllThatWasOfferedWhenAskedForIt) {
  std::mt19937 random(3);
  for (int round = 0; round < 1000; ++round) {
    std::vector<Pass> passes;
    std::vector<std::size_t> units;
    for (int i = 0; i < 5; ++i) {
      units.push_back(random() % 300);
      passes.push_back({ExtractionStep::other, units.back(), 1e-7 * static_cast<double>(1 + random() % 1000000)});
    }
    SliceCursor cursor(passes);
    const double offered = cursor.left();
    double done = 0;
    std::vector<std::size_t> taken(units.size());
    while (!cursor.is_at_end()) {
      const auto piece = cursor.take(offered - done, done == 0);
      ASSERT_TRUE(piece) << "round " << round << ": " << offered - done << " left of " << offered;
      EXPECT_EQ(piece->run.first, taken[piece->pass]);
      taken[piece->pass] += piece->run.count;
      done += piece->size;
    }
    EXPECT_EQ(taken, units);
  }
}

TEST(SliceCursor, LearnsHowManyUnitsThereAreAfterAll) {
  SliceCursor cursor({{ExtractionStep::other, 1, 1.0}, {ExtractionStep::other, 10, 1.0}});
  static_cast<void>(cursor.take(1, true));
  cursor.set_units_left(1, 3);
  EXPECT_DOUBLE_EQ(cursor.left(), 3);
  static_cast<void>(cursor.take(1, true));
  cursor.set_units_left(1, 1);
  EXPECT_DOUBLE_EQ(cursor.left(), 1);
  static_cast<void>(cursor.take(1, true));
  EXPECT_TRUE(cursor.is_at_end());
  // More than was thought: the pass goes on.
  cursor.set_units_left(1, 2);
  ASSERT_FALSE(cursor.is_at_end());
  EXPECT_EQ(cursor.take(5, true)->run.count, 2U);
  cursor.set_units_left(1, 0);
  EXPECT_TRUE(cursor.is_at_end());
}

}  // namespace
}  // namespace foreview::batched
