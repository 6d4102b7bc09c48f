#include "foreview/viewer/viewer_control.h"

#include <gtest/gtest.h>

#include <cmath>

namespace foreview {
namespace {

Timestamp at(double seconds) {
  return Timestamp{} + Duration::from_seconds(seconds);
}

/// A recording of ten seconds with a picture every half second, in simulated time.
class ViewerControlTest : public ::testing::Test {
 protected:
  static PlaybackClock::Options clock_options() {
    PlaybackClock::Options options;
    options.first = at(100);
    options.last = at(110);
    return options;
  }
  static ViewerControl::Options control_options() {
    ViewerControl::Options options;
    for (int i = 0; i <= 20; ++i) options.steps.push_back(at(100 + 0.5 * i));
    options.link.delay = Duration::from_seconds(0.5);
    options.camera.width = 400;
    options.camera.height = 300;
    options.camera.focal_length = {300, 300};
    options.camera.principal_point = {200, 150};
    options.surroundings = {{0, 0, 0}, 2, {0, 0, 1}};
    return options;
  }
  void pass(double seconds) { real_ = real_ + Duration::from_seconds(seconds); }
  [[nodiscard]] double time() const { return (clock_.now().time - at(100)).seconds(); }
  [[nodiscard]] const ViewerControl::Settings& settings() const { return control_.settings(); }

  static FramePointer pointer(double x, double y) {
    FramePointer result;
    result.position = {x, y};
    result.frame_size = {800, 600};
    result.over_frame = true;
    return result;
  }
  /// Press at one place, move to another, release.
  void drag(bool left, glm::dvec2 from, glm::dvec2 to, bool shift = false) {
    FramePointer mouse = pointer(from.x, from.y);
    mouse.shift = shift;
    mouse.left = mouse.left_pressed = left;
    mouse.right = mouse.right_pressed = !left;
    control_.point(mouse);
    mouse.left_pressed = mouse.right_pressed = false;
    mouse.position = to;
    control_.point(mouse);
    mouse.left = mouse.right = false;
    control_.point(mouse);
  }
  void settle() {
    for (int i = 0; i < 200; ++i) control_.advance(0.02, Pose());
  }

  Timestamp real_ = at(5);
  PlaybackClock clock_{clock_options(), [this] { return real_; }};
  ViewerControl control_{control_options(), &clock_};
};

TEST_F(ViewerControlTest, TabGoesThroughAllViews) {
  for (const ViewMode expected :
       {ViewMode::delayed, ViewMode::side_by_side, ViewMode::split, ViewMode::difference, ViewMode::predicted}) {
    control_.act(ViewerAction::next_view);
    EXPECT_EQ(settings().choice.mode, expected);
  }
  control_.act(ViewerAction::view_split);
  EXPECT_EQ(settings().choice.mode, ViewMode::split);
}

TEST_F(ViewerControlTest, EdgesBringTheDelayedPictureUp) {
  control_.act(ViewerAction::toggle_edges);
  EXPECT_TRUE(settings().choice.overlays.edges);
  EXPECT_EQ(settings().choice.mode, ViewMode::delayed);
  control_.act(ViewerAction::toggle_edges);
  EXPECT_FALSE(settings().choice.overlays.edges);
  control_.act(ViewerAction::view_split);
  control_.act(ViewerAction::toggle_edges);
  EXPECT_EQ(settings().choice.mode, ViewMode::split) << "it shows the delayed picture already";
}

TEST_F(ViewerControlTest, OneHeatMapAtATime) {
  control_.act(ViewerAction::toggle_age);
  control_.act(ViewerAction::toggle_density);
  EXPECT_FALSE(settings().choice.overlays.age);
  EXPECT_TRUE(settings().choice.overlays.density);
}

TEST_F(ViewerControlTest, PausesGoesOnAndBeginsAnewAtTheEnd) {
  pass(1);
  control_.act(ViewerAction::pause);
  pass(3);
  EXPECT_NEAR(time(), 1, 1e-6);
  control_.act(ViewerAction::pause);
  pass(2);
  EXPECT_NEAR(time(), 3, 1e-6);
  pass(100);
  EXPECT_TRUE(clock_.at_end());
  control_.act(ViewerAction::pause);
  pass(0.5);
  EXPECT_NEAR(time(), 0.5, 1e-6);
}

TEST_F(ViewerControlTest, StepsStopAtPictures) {
  pass(1.2);
  control_.act(ViewerAction::step_forward);
  EXPECT_NEAR(time(), 1.5, 1e-9);
  control_.act(ViewerAction::step_forward);
  EXPECT_NEAR(time(), 2, 1e-9);
  pass(10);
  EXPECT_NEAR(time(), 2, 1e-9) << "stepping pauses";
  control_.act(ViewerAction::step_back);
  EXPECT_NEAR(time(), 1.5, 1e-9);
  control_.act(ViewerAction::to_start);
  control_.act(ViewerAction::step_back);
  EXPECT_NEAR(time(), 0, 1e-9);
  control_.act(ViewerAction::to_end);
  EXPECT_NEAR(time(), 10, 1e-9);
  control_.act(ViewerAction::step_forward);
  EXPECT_NEAR(time(), 10, 1e-9);
}

TEST_F(ViewerControlTest, SpeedGoesThroughItsSteps) {
  control_.act(ViewerAction::faster);
  EXPECT_EQ(clock_.speed(), 2);
  for (int i = 0; i < 20; ++i) control_.act(ViewerAction::faster);
  EXPECT_EQ(clock_.speed(), ViewerControl::kSpeeds.back());
  for (int i = 0; i < 20; ++i) control_.act(ViewerAction::slower);
  EXPECT_EQ(clock_.speed(), ViewerControl::kSpeeds.front());
  clock_.set_speed(1.3);
  control_.act(ViewerAction::slower);
  EXPECT_EQ(clock_.speed(), 1);
  clock_.set_speed(1.3);
  control_.act(ViewerAction::faster);
  EXPECT_EQ(clock_.speed(), 2);
}

TEST_F(ViewerControlTest, DelayStaysWithinItsRange) {
  control_.act(ViewerAction::more_delay);
  EXPECT_NEAR(settings().link.delay.seconds(), 0.6, 1e-9);
  for (int i = 0; i < 50; ++i) control_.act(ViewerAction::more_delay);
  EXPECT_NEAR(settings().link.delay.seconds(), ViewerControl::kMostDelay, 1e-9);
  for (int i = 0; i < 50; ++i) control_.act(ViewerAction::less_delay);
  EXPECT_EQ(settings().link.delay.nanoseconds, 0);
}

TEST_F(ViewerControlTest, RequestsComeOnce) {
  control_.act(ViewerAction::save_picture);
  control_.act(ViewerAction::copy_command);
  EXPECT_TRUE(control_.take_save_request());
  EXPECT_FALSE(control_.take_save_request());
  EXPECT_TRUE(control_.take_copy_request());
  EXPECT_FALSE(control_.take_copy_request());
  control_.settings().panels = false;
  control_.act(ViewerAction::enter_panels);
  EXPECT_TRUE(settings().panels) << "there must be something to enter";
  EXPECT_TRUE(control_.take_enter_request());
}

TEST_F(ViewerControlTest, EscapeClosesTheHelpBeforeTheWindow) {
  control_.act(ViewerAction::toggle_help);
  control_.act(ViewerAction::quit);
  EXPECT_FALSE(settings().help);
  EXPECT_FALSE(control_.quit());
  control_.act(ViewerAction::quit);
  EXPECT_TRUE(control_.quit());
}

TEST_F(ViewerControlTest, TheSplitLineIsDragged) {
  control_.act(ViewerAction::view_split);
  EXPECT_TRUE(control_.over_split(pointer(404, 100)));
  EXPECT_FALSE(control_.over_split(pointer(450, 100)));
  drag(true, {402, 300}, {200, 350});
  EXPECT_NEAR(settings().choice.split, 0.25, 1e-9);
  EXPECT_EQ(control_.camera().mode(), CameraMode::follow) << "the camera must not turn meanwhile";
  drag(true, {200, 300}, {-500, 350});
  EXPECT_EQ(settings().choice.split, 0);
  control_.act(ViewerAction::split_right);
  EXPECT_NEAR(settings().choice.split, 0.02, 1e-9);
}

TEST_F(ViewerControlTest, DraggingFromTheRecordedPoseLooksAround) {
  settle();
  drag(true, {400, 300}, {300, 300});
  settle();
  EXPECT_EQ(control_.camera().mode(), CameraMode::look_around);
  EXPECT_EQ(settings().choice.camera, CameraMode::look_around);
  // What was under the mouse goes with it: a sixth of the picture's height to the left is a turn to the right.
  const double expected = 2 * std::atan(150.0 / 300) * 100 / 600;
  EXPECT_NEAR(settings().choice.turn.x, expected, expected * 0.02);
  EXPECT_NEAR(settings().choice.turn.y, 0, 1e-6);
}

TEST_F(ViewerControlTest, AClickMovesNothing) {
  settle();
  drag(true, {400, 300}, {400, 300});
  settle();
  EXPECT_EQ(control_.camera().mode(), CameraMode::follow);
}

TEST_F(ViewerControlTest, ADragThatBeganOnAPanelMovesNothing) {
  FramePointer mouse = pointer(400, 300);
  mouse.left = true;  // no left_pressed: it went down elsewhere
  control_.point(mouse);
  mouse.position = {100, 100};
  control_.point(mouse);
  settle();
  EXPECT_EQ(control_.camera().mode(), CameraMode::follow);
}

TEST_F(ViewerControlTest, TheWheelNarrowsTheFieldOfView) {
  FramePointer mouse = pointer(400, 300);
  mouse.wheel = 1;
  control_.point(mouse);
  ASSERT_TRUE(settings().choice.field_of_view);
  EXPECT_LT(*settings().choice.field_of_view, 2 * std::atan(0.5));
  control_.act(ViewerAction::reset_camera);
  EXPECT_FALSE(settings().choice.field_of_view);
}

TEST_F(ViewerControlTest, TheWheelGoesNearerInTheFreeCamera) {
  control_.set_camera_mode(CameraMode::overview);
  settle();
  const glm::dvec3 before = control_.camera().pose().translation;
  FramePointer mouse = pointer(400, 300);
  mouse.wheel = 3;
  control_.point(mouse);
  settle();
  EXPECT_FALSE(settings().choice.field_of_view);
  EXPECT_GT(glm::length(control_.camera().pose().translation - before), 0.1);
  ASSERT_TRUE(settings().choice.pose) << "the choice says where the camera is";
  EXPECT_EQ(settings().choice.pose->translation, control_.camera().pose().translation);
}

TEST_F(ViewerControlTest, HeldKeysFlyAndStop) {
  control_.set_camera_mode(CameraMode::free);
  settle();
  std::bitset<kMoveKeys> keys;
  keys.set(static_cast<std::size_t>(MoveKey::forward));
  control_.hold(keys);
  const glm::dvec3 before = control_.camera().pose().translation;
  for (int i = 0; i < 50; ++i) control_.advance(0.02, Pose());
  const glm::dvec3 moved = control_.camera().pose().translation - before;
  EXPECT_GT(glm::length(moved), 0.3);
  control_.hold({});
  settle();
  const glm::dvec3 rest = control_.camera().pose().translation;
  settle();
  EXPECT_LT(glm::length(control_.camera().pose().translation - rest), 1e-6);
}

TEST_F(ViewerControlTest, CameraModesInOrder) {
  for (const CameraMode expected :
       {CameraMode::look_around, CameraMode::free, CameraMode::overview, CameraMode::follow}) {
    control_.act(ViewerAction::next_camera);
    EXPECT_EQ(control_.camera().mode(), expected);
    EXPECT_EQ(settings().choice.camera, expected);
  }
}

TEST(ViewerControlLive, NothingCanStopTime) {
  ViewerControl control({}, nullptr);
  for (const ViewerAction action :
       {ViewerAction::pause, ViewerAction::step_back, ViewerAction::step_forward, ViewerAction::to_start,
        ViewerAction::to_end, ViewerAction::faster, ViewerAction::slower, ViewerAction::toggle_loop}) {
    control.act(action);
    EXPECT_NE(control.take_refusal().find("live"), std::string::npos) << "no reason was given";
    EXPECT_EQ(control.take_refusal(), "") << "said twice";
  }
  control.scrub(at(3));
  EXPECT_FALSE(control.quit());
  control.act(ViewerAction::more_delay);
  EXPECT_EQ(control.take_refusal(), "") << "a simulated link is in front of live streams, too";
  EXPECT_GT(control.settings().link.delay, Duration{});
}

}  // namespace
}  // namespace foreview
