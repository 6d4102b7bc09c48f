#include "foreview/server/stream_restart.h"

#include <gtest/gtest.h>

namespace foreview {
namespace {

using Verdict = StreamRestart::Verdict;

/// Pictures of some publishers that arrive one after the other.
struct Stream {
  StreamRestart restart;
  Timestamp now{5'000'000'000'000};

  [[nodiscard]] static constexpr Duration ms(std::int64_t count) { return {count * 1'000'000}; }
  Verdict picture(std::int64_t stamp_ms, std::uint64_t publisher = 1, Duration gap = ms(10)) {
    now = now + gap;
    return restart.note(Timestamp{ms(stamp_ms).nanoseconds}, publisher, now);
  }
};

TEST(StreamRestart, TellsANewStreamFromOvertaking) {
  Stream stream;
  EXPECT_EQ(stream.picture(100'000), Verdict::continues);
  EXPECT_EQ(stream.picture(100'100), Verdict::continues);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(stream.picture(98'500 + 10 * i), Verdict::continues);  // late, not too late
  EXPECT_EQ(stream.picture(97'000), Verdict::continues);
  EXPECT_EQ(stream.picture(97'100), Verdict::continues);
  EXPECT_EQ(stream.picture(100'200), Verdict::continues);  // they were stragglers
  EXPECT_EQ(stream.picture(97'000), Verdict::continues);
  EXPECT_EQ(stream.picture(97'100), Verdict::continues);
  EXPECT_EQ(stream.picture(97'200), Verdict::begins_anew);
  EXPECT_EQ(stream.picture(97'300), Verdict::continues);
  EXPECT_EQ(stream.picture(0), Verdict::begins_anew);  // far back: at once
  EXPECT_EQ(stream.picture(50'000), Verdict::continues);
}

TEST(StreamRestart, ClockSetBackALittleIsToldByCountingOn) {
  Stream stream;
  for (int i = 0; i < 50; ++i) EXPECT_EQ(stream.picture(100'000 + 33 * i, 1, Stream::ms(33)), Verdict::continues);
  int pictures = 0;
  while (stream.picture(100'600 + 33 * pictures, 1, Stream::ms(33)) == Verdict::continues) ASSERT_LT(++pictures, 30);
  EXPECT_GE(pictures * 33, 450);
  EXPECT_LE(pictures * 33, 550);
  // A single newer one in between: they were late.
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(stream.picture(110'000 + 33 * i, 1, Stream::ms(16)), Verdict::continues);
    EXPECT_EQ(stream.picture(109'000 + 33 * i, 1, Stream::ms(16)), Verdict::continues);
  }
}

TEST(StreamRestart, AnotherPublisherTakesOverOnceTheFirstIsSilent) {
  Stream stream;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(stream.picture(100'000 + 33 * i, 1, Stream::ms(33)), Verdict::continues);
  EXPECT_EQ(stream.picture(100'050, 2, Stream::ms(33)), Verdict::straggles);  // 0.6 s back
  EXPECT_EQ(stream.picture(100'083, 2, Stream::ms(33)), Verdict::straggles);
  EXPECT_EQ(stream.picture(100'116, 2, Stream::ms(33)), Verdict::straggles);  // the first may yet go on
  EXPECT_EQ(stream.restart.publisher(), 1U);
  int pictures = 0;
  while (stream.picture(100'149 + 33 * pictures, 2, Stream::ms(33)) == Verdict::straggles) ASSERT_LT(++pictures, 30);
  EXPECT_EQ(stream.restart.publisher(), 2U);
  EXPECT_LE(pictures, 13);  // half a second in all
  EXPECT_EQ(stream.picture(101'000, 2), Verdict::continues);
}

TEST(StreamRestart, AnotherPublisherWhoseStampsGoOnContinuesTheStream) {
  Stream stream;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(stream.picture(100'000 + 33 * i, 1, Stream::ms(33)), Verdict::continues);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(stream.picture(101'000 + 33 * i, 2, Stream::ms(33)), Verdict::continues);
  EXPECT_EQ(stream.restart.publisher(), 2U);
}

TEST(StreamRestart, TwoPublishersAtOnceDoNotTearTheStreamApart) {
  Stream stream;
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(stream.picture(100'000 + 100 * i, 1, Stream::ms(50)), Verdict::continues);
    // Many of another's between two of the first's, with stamps of all kinds.
    for (int k = 0; k < 5; ++k) EXPECT_EQ(stream.picture(20 * i + k, 2), Verdict::straggles);
    EXPECT_EQ(stream.picture(1'000'000, 3, Stream::ms(0)), Verdict::continues);
  }
  EXPECT_EQ(stream.restart.publisher(), 1U);
}

TEST(StreamRestart, ASlowCameraIsNotTakenForSilent) {
  Stream stream;
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(stream.picture(100'000 + 1000 * i, 1, Stream::ms(400)), Verdict::continues);
    for (int k = 0; k < 6; ++k) static_cast<void>(stream.picture(20 * i + k, 2, Stream::ms(100)));
    EXPECT_EQ(stream.restart.publisher(), 1U) << i;
  }
}

}  // namespace
}  // namespace foreview
