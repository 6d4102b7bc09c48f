#include "foreview/server/stream_restart.h"

#include <gtest/gtest.h>

namespace foreview {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(StreamRestart, TellsANewStreamFromOvertaking) {
  StreamRestart restart;
  const auto ms = [](std::int64_t count) { return Timestamp{count * kMs}; };
  EXPECT_FALSE(restart.begins_anew(ms(100'000)));
  EXPECT_FALSE(restart.begins_anew(ms(100'100)));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(restart.begins_anew(ms(98'500 + 10 * i)));  // late, not too late
  EXPECT_FALSE(restart.begins_anew(ms(97'000)));
  EXPECT_FALSE(restart.begins_anew(ms(97'100)));
  EXPECT_FALSE(restart.begins_anew(ms(100'200)));  // they were stragglers
  EXPECT_FALSE(restart.begins_anew(ms(97'000)));
  EXPECT_FALSE(restart.begins_anew(ms(97'100)));
  EXPECT_TRUE(restart.begins_anew(ms(97'200)));
  EXPECT_FALSE(restart.begins_anew(ms(97'300)));
  EXPECT_TRUE(restart.begins_anew(ms(0)));  // far back: at once
  EXPECT_FALSE(restart.begins_anew(ms(50'000)));
}

}  // namespace
}  // namespace foreview
