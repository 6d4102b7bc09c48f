#include "foreview/server/playback_clock.h"

#include <gtest/gtest.h>

#include "foreview/scene/errors.h"
#include "played_recording.h"

namespace foreview {
namespace {

using test::milliseconds;
using test::SimulatedTime;

constexpr Timestamp at_ms(std::int64_t count) {
  return {count * 1'000'000};
}

struct PlaybackClockTest : testing::Test {
  PlaybackClock make(double speed = 1, bool loop = false, bool playing = true) {
    return PlaybackClock({at_ms(1000), at_ms(3000), speed, loop, playing}, real.source());
  }
  SimulatedTime real;
};

TEST_F(PlaybackClockTest, PlaysPausesAndStaysAtTheEnd) {
  PlaybackClock clock = make();
  real.advance(milliseconds(300));
  EXPECT_EQ(clock.now().time, at_ms(1300));
  clock.pause();
  real.advance(milliseconds(500));
  EXPECT_EQ(clock.now().time, at_ms(1300));
  EXPECT_FALSE(clock.real_time_of(at_ms(1400)));
  clock.play();
  real.advance(milliseconds(100));
  EXPECT_EQ(clock.now().time, at_ms(1400));
  EXPECT_EQ(clock.now().generation, 0U);
  EXPECT_FALSE(clock.at_end());
  real.advance(milliseconds(9000));
  EXPECT_EQ(clock.now().time, at_ms(3000));
  EXPECT_TRUE(clock.at_end());
  clock.play();
  EXPECT_EQ(clock.now().time, at_ms(1000));
  EXPECT_EQ(clock.now().generation, 1U);
}

TEST_F(PlaybackClockTest, SpeedChangesWithoutALeap) {
  PlaybackClock clock = make(2);
  real.advance(milliseconds(100));
  EXPECT_EQ(clock.now().time, at_ms(1200));
  clock.set_speed(0.5);
  EXPECT_EQ(clock.now().time, at_ms(1200));
  real.advance(milliseconds(100));
  EXPECT_EQ(clock.now().time, at_ms(1250));
  EXPECT_EQ(clock.now().generation, 0U);
  EXPECT_THROW(clock.set_speed(0), InputError);
  EXPECT_THROW(clock.set_speed(-1), InputError);
  EXPECT_EQ(clock.speed(), 0.5);
}

TEST_F(PlaybackClockTest, SeekIsANewGenerationWithinTheRecording) {
  PlaybackClock clock = make();
  clock.seek(at_ms(2500));
  EXPECT_EQ(clock.now().time, at_ms(2500));
  EXPECT_EQ(clock.now().generation, 1U);
  clock.seek(at_ms(99999));
  EXPECT_EQ(clock.now().time, at_ms(3000));
  clock.seek(at_ms(0));
  EXPECT_EQ(clock.now().time, at_ms(1000));
  EXPECT_EQ(clock.now().generation, 3U);
}

TEST_F(PlaybackClockTest, LoopBeginsAnewAndEachRoundIsAGeneration) {
  PlaybackClock clock = make(1, true);
  real.advance(milliseconds(2500));
  EXPECT_EQ(clock.now().time, at_ms(1500));
  EXPECT_EQ(clock.now().generation, 1U);
  real.advance(milliseconds(6000));
  EXPECT_EQ(clock.now().time, at_ms(1500));
  EXPECT_EQ(clock.now().generation, 4U);
  clock.set_loop(false);
  real.advance(milliseconds(6000));
  EXPECT_EQ(clock.now().time, at_ms(3000));
  EXPECT_EQ(clock.now().generation, 4U);
}

TEST_F(PlaybackClockTest, DisplayTimeAndRealTimeAreEachOthersInverse) {
  PlaybackClock clock = make(2);
  real.advance(milliseconds(50));
  EXPECT_EQ(clock.real_time_of(at_ms(1500)), at_ms(250));
  EXPECT_EQ(clock.at(at_ms(250)).time, at_ms(1500));
  EXPECT_FALSE(clock.real_time_of(at_ms(1050)));  // is past
  EXPECT_FALSE(clock.real_time_of(at_ms(3001)));
}

TEST_F(PlaybackClockTest, RefusesARecordingThatEndsBeforeItBegins) {
  EXPECT_THROW(PlaybackClock({at_ms(2), at_ms(1)}, real.source()), InputError);
  PlaybackClock instant({at_ms(2), at_ms(2), 1, true}, real.source());
  real.advance(milliseconds(50));
  EXPECT_EQ(instant.now().time, at_ms(2));
}

}  // namespace
}  // namespace foreview
