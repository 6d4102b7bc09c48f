#include "foreview/scene/timestamp.h"

#include <gtest/gtest.h>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

TEST(Timestamp, KeepsNanosecondsThatADoubleWouldLose) {
  Timestamp t;
  ASSERT_TRUE(Timestamp::parse_seconds("1700000000.123456789", t));
  EXPECT_EQ(t.nanoseconds, 1700000000123456789);
  EXPECT_EQ(t.to_string(), "1700000000.123456789");
  ASSERT_TRUE(Timestamp::parse_seconds("-0.5", t));
  EXPECT_EQ(t.nanoseconds, -500000000);
  EXPECT_EQ(t.to_string(), "-0.500000000");
}

TEST(Timestamp, ReadsExponents) {
  Timestamp t;
  ASSERT_TRUE(Timestamp::parse_seconds("1.5e3", t));
  EXPECT_EQ(t.nanoseconds, 1500000000000);
}

TEST(Timestamp, RefusesWhatIsNoNumber) {
  Timestamp t{7};
  for (const char* text : {"", "abc", "1.2.3", "nan", "inf", "1e300", "99999999999999999999", "1 2", "--1"}) {
    EXPECT_FALSE(Timestamp::parse_seconds(text, t)) << text;
  }
  EXPECT_EQ(t.nanoseconds, 7);
}

TEST(Duration, ReadsUnits) {
  EXPECT_EQ(Duration::parse("500ms", "--delay").nanoseconds, 500000000);
  EXPECT_EQ(Duration::parse("0.5 s", "--delay").nanoseconds, 500000000);
  EXPECT_EQ(Duration::parse("2", "--delay").nanoseconds, 2000000000);
  EXPECT_EQ(Duration::parse("40us", "--delay").nanoseconds, 40000);
  EXPECT_EQ(Duration::parse("2min", "--duration").nanoseconds, 120'000'000'000);
  EXPECT_EQ(Duration::parse("1h", "--duration").nanoseconds, 3'600'000'000'000);
}

TEST(Duration, NamesTheOptionInItsError) {
  try {
    (void)Duration::parse("5 parsecs", "--delay");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("--delay"), std::string::npos);
  }
  EXPECT_THROW((void)Duration::parse("nan", "--delay"), InputError);
  EXPECT_THROW((void)Duration::parse("1e300s", "--delay"), InputError);
}

}  // namespace
}  // namespace foreview
