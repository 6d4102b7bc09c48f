#include "foreview/viewer/replay_control.h"

#include <gtest/gtest.h>

namespace foreview {
namespace {

using Key = ReplayControl::Key;

constexpr Timestamp at(std::int64_t milliseconds) {
  return {milliseconds * 1'000'000};
}
constexpr Duration ms(std::int64_t milliseconds) {
  return {milliseconds * 1'000'000};
}

/// 100 pictures, 40 ms apart, the first at 1000 ms.
ReplayControl::Options options() {
  ReplayControl::Options result;
  result.first = at(1000);
  result.last = at(1000 + 99 * 40);
  result.delay = ms(500);
  for (int i = 0; i < 100; ++i) {
    result.steps.push_back(at(1000 + i * 40));
    result.captures.push_back(at(1000 + i * 40));
  }
  return result;
}

TEST(ReplayControlKeys, TabGoesThroughTheModes) {
  ReplayControl control(options());
  EXPECT_EQ(control.choice().mode, ViewMode::predicted);
  control.press(Key::tab);
  EXPECT_EQ(control.choice().mode, ViewMode::delayed);
  control.press(Key::tab);
  EXPECT_EQ(control.choice().mode, ViewMode::side_by_side);
  control.press(Key::tab);
  EXPECT_EQ(control.choice().mode, ViewMode::split);
  control.press(Key::tab);
  EXPECT_EQ(control.choice().mode, ViewMode::difference);
  control.press(Key::tab);
  EXPECT_EQ(control.choice().mode, ViewMode::predicted);
}

TEST(ReplayControlKeys, OverlaysToggle) {
  ReplayControl control(options());
  control.press(Key::h);
  control.press(Key::w);
  EXPECT_TRUE(control.choice().overlays.holes);
  EXPECT_TRUE(control.choice().overlays.wireframe);
  EXPECT_FALSE(control.choice().overlays.edges);
  control.press(Key::h);
  control.press(Key::w);
  EXPECT_FALSE(control.choice().overlays.holes);
  EXPECT_FALSE(control.choice().overlays.wireframe);
}

TEST(ReplayControlKeys, MBringsTheDelayedPictureUp) {
  ReplayControl control(options());
  control.press(Key::m);
  EXPECT_TRUE(control.choice().overlays.edges);
  EXPECT_EQ(control.choice().mode, ViewMode::delayed);
  control.press(Key::m);
  EXPECT_FALSE(control.choice().overlays.edges);
  EXPECT_EQ(control.choice().mode, ViewMode::delayed);
}

TEST(ReplayControlKeys, MLeavesAModeThatShowsTheDelayedPicture) {
  ReplayControl::Options both = options();
  both.choice.mode = ViewMode::side_by_side;
  ReplayControl control(both);
  control.press(Key::m);
  EXPECT_EQ(control.choice().mode, ViewMode::side_by_side);
}

TEST(ReplayControlKeys, SaveIsAskedForOnce) {
  ReplayControl control(options());
  EXPECT_FALSE(control.take_save_request());
  control.press(Key::s);
  EXPECT_TRUE(control.take_save_request());
  EXPECT_FALSE(control.take_save_request());
}

TEST(ReplayControlKeys, EscapeAndQQuit) {
  for (const Key key : {Key::escape, Key::q}) {
    ReplayControl control(options());
    EXPECT_FALSE(control.quit());
    control.press(key);
    EXPECT_TRUE(control.quit());
  }
}

TEST(ReplayControlKeys, ArrowsStepOnlyWhilePaused) {
  ReplayControl control(options());
  control.press(Key::right);
  EXPECT_EQ(control.time(), at(1000));
  control.press(Key::space);
  control.press(Key::right);
  EXPECT_EQ(control.time(), at(1040));
  control.press(Key::right);
  control.press(Key::left);
  EXPECT_EQ(control.time(), at(1040));
  control.press(Key::left);
  control.press(Key::left);
  EXPECT_EQ(control.time(), at(1000));
}

TEST(ReplayControlKeys, ArrowsFindTheNextPictureFromBetweenTwo) {
  ReplayControl control(options());
  control.tick(ms(50));
  ASSERT_EQ(control.time(), at(1050));
  control.press(Key::space);
  control.press(Key::left);
  EXPECT_EQ(control.time(), at(1040));
  control.press(Key::space);
  control.tick(ms(10));
  control.press(Key::space);
  control.press(Key::right);
  EXPECT_EQ(control.time(), at(1080));
}

TEST(ReplayControlTime, FollowsTheClockTimesSpeed) {
  ReplayControl::Options slow = options();
  slow.speed = 0.25;
  ReplayControl control(slow);
  control.tick(ms(100));
  EXPECT_EQ(control.time(), at(1025));
  control.tick(ms(20));
  EXPECT_EQ(control.time(), at(1030));
  EXPECT_DOUBLE_EQ(control.pace(), 1);
}

TEST(ReplayControlTime, StandsWhilePaused) {
  ReplayControl control(options());
  control.press(Key::space);
  control.tick(ms(100));
  EXPECT_EQ(control.time(), at(1000));
  control.press(Key::space);
  control.tick(ms(100));
  EXPECT_EQ(control.time(), at(1100));
}

TEST(ReplayControlTime, GoesFarWhereNoPictureBecomesDue) {
  ReplayControl control(options());
  // Until 1500 ms no picture is older than the delay; just after it the first one is, after 1540 the second.
  control.tick(ms(10'000));
  EXPECT_EQ(control.time(), at(1540));
}

TEST(ReplayControlTime, WaitsInsteadOfSkippingPictures) {
  ReplayControl control(options());
  control.tick(ms(510));
  ASSERT_EQ(control.time(), at(1510));
  std::int64_t due_before = 1;  // captures with stamp < 1510 - 500
  for (int i = 0; i < 20; ++i) {
    control.tick(ms(400));
    const std::int64_t age = control.time().nanoseconds / 1'000'000 - 500 - 1000;
    const std::int64_t due = age <= 0 ? 0 : (age + 39) / 40;
    EXPECT_LE(due - due_before, 1) << "at " << control.time().to_string();
    due_before = due;
  }
  // 40 ms of display time per 400 ms of real time.
  EXPECT_NEAR(control.pace(), 0.1, 0.01);
  EXPECT_NE(control.title("workcell", 2.5).find("slower than real time (0.10 x)"), std::string::npos)
      << control.title("workcell", 2.5);
}

TEST(ReplayControlTime, StaysAtTheEndAndBeginsAnewOnSpace) {
  ReplayControl::Options no_captures = options();
  no_captures.captures.clear();
  ReplayControl control(no_captures);
  control.tick(ms(60'000));
  EXPECT_EQ(control.time(), no_captures.last);
  EXPECT_TRUE(control.at_end());
  EXPECT_DOUBLE_EQ(control.pace(), 1);
  control.tick(ms(60'000));
  EXPECT_EQ(control.time(), no_captures.last);
  control.press(Key::space);
  EXPECT_EQ(control.time(), no_captures.first);
  control.tick(ms(10));
  EXPECT_EQ(control.time(), at(1010));
}

TEST(ReplayControlTime, StepsBackFromTheEnd) {
  ReplayControl::Options no_captures = options();
  no_captures.captures.clear();
  ReplayControl control(no_captures);
  control.tick(ms(60'000));
  control.press(Key::left);
  EXPECT_EQ(control.time(), no_captures.last - ms(40));
  EXPECT_TRUE(control.paused());
}

TEST(ReplayControlTime, Loops) {
  ReplayControl::Options looping = options();
  looping.captures.clear();
  looping.loop = true;
  ReplayControl control(looping);
  control.tick(ms(60'000));
  EXPECT_EQ(control.time(), looping.first);
  EXPECT_FALSE(control.at_end());
  control.tick(ms(10));
  EXPECT_EQ(control.time(), at(1010));
}

TEST(ReplayControlTime, SurvivesAReplayOfOneInstant) {
  ReplayControl::Options one = options();
  one.last = one.first;
  one.steps = {one.first};
  one.captures = {one.first};
  ReplayControl control(one);
  control.tick(ms(100));
  EXPECT_EQ(control.time(), one.first);
  control.press(Key::left);
  control.press(Key::right);
  EXPECT_EQ(control.time(), one.first);
}

TEST(ReplayControlTitle, ShowsTimeDelayAndRate) {
  ReplayControl control(options());
  control.tick(ms(250));
  EXPECT_EQ(control.title("workcell", 49.6), "foreview: workcell | predicted | 0.25 s | delay 500 ms | 50 fps");
  control.press(Key::space);
  EXPECT_EQ(control.title("workcell", 49.6),
            "foreview: workcell | predicted | 0.25 s | delay 500 ms | 50 fps | paused");
}

}  // namespace
}  // namespace foreview
