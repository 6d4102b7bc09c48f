#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "foreview/recordings/builtin.h"
#include "support/temporary_directory.h"
#include "viewer/run_foreview.h"
#include "viewer/virtual_display.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using test::RunningForeview;
using test::TemporaryDirectory;
using test::VirtualDisplay;
using test::WallRecording;

constexpr double kPatience = 30;  // seconds, for a loaded machine
constexpr const char* kWindow = "foreview";

void pause(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

/// The viewer with its panels, as a person at the screen uses it, and what can happen to it.
class ViewerSession : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed: the viewer was NOT tested";
    display_.emplace(1100, 800);
    WallRecording::write(recording_.path() / "wall", 16);
  }

  void start(std::vector<std::string> more, std::map<std::string, std::string> environment = {}) {
    std::vector<std::string> arguments{"view",  (recording_ / "wall").string(), "--delay", "120ms",
                                       "--out", out_.path().string(),           "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    environment["DISPLAY"] = display_->name();
    running_.emplace(arguments, environment);
  }
  std::string wait_for_title(const std::string& part) { return display_->wait_for_title(kWindow, part, kPatience); }
  void press(const std::string& key, unsigned modifiers = 0) {
    display_->press(kWindow, key, modifiers);
    pause(80);
  }
  [[nodiscard]] bool alive() { return !running_->wait(0.01).has_value(); }
  [[nodiscard]] nlohmann::json summary() const { return nlohmann::json::parse(std::ifstream(out_ / "summary.json")); }

  TemporaryDirectory recording_, out_;
  std::optional<VirtualDisplay> display_;
  std::optional<RunningForeview> running_;
};

#define ASSERT_TITLE_COMES(part)                                                                             \
  do {                                                                                                       \
    const std::string title_seen = wait_for_title(part);                                                     \
    ASSERT_NE(title_seen.find(part), std::string::npos) << title_seen << "\n" << running_->standard_error(); \
  } while (false)

TEST_F(ViewerSession, EverythingOnceWithoutErrorOrLeak) {
  start({"--loop", "--json", (out_ / "summary.json").string()});
  ASSERT_TITLE_COMES("| 0.");
  // Views, each with every overlay.
  for (const char* view : {"1", "2", "3", "4", "5"}) {
    press(view);
    for (const char* overlay : {"h", "n", "a", "d", "w", "f", "i"}) press(overlay);
    ASSERT_TRUE(alive()) << running_->standard_error();
  }
  press("1");
  press("m");
  ASSERT_TITLE_COMES("| delayed |");
  press("m");
  // The split line, and cameras.
  press("4");
  ASSERT_TITLE_COMES("| split |");
  display_->drag_mouse(kWindow, 1, {300, 200}, {150, 220});
  press("1");
  display_->drag_mouse(kWindow, 1, {300, 200}, {350, 220});
  for (int i = 0; i < 4; ++i) {
    press("c");
    display_->drag_mouse(kWindow, i % 2 == 0 ? 1 : 3, {300, 200}, {330, 180});
    display_->mouse_button(kWindow, 4, true);
    display_->mouse_button(kWindow, 4, false);
  }
  press("r");
  // Time.
  for (const char* key : {"space", "Left", "Right", "Home", "minus", "equal", "l", "l", "space"}) press(key);
  // The delay, by key and by slider.
  press("bracketright");
  press("bracketright");
  press("bracketright");
  ASSERT_TITLE_COMES("| delay 400 ms |");
  display_->drag_mouse(kWindow, 1, {760, 304}, {919, 304});
  ASSERT_TITLE_COMES("| delay 3000 ms |");
  // Every widget once, by keyboard alone; help on top.
  press("F2");
  for (int i = 0; i < 16; ++i) {
    press("Down");
    press("space");
    press("Escape");
    press("F2");
  }
  press("Escape");
  press("F1");
  press("F1");
  press("p");
  press("p");
  ASSERT_TRUE(alive()) << running_->standard_error();
  // What window systems do.
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    display_->resize(kWindow, 1 + static_cast<int>(random() % 1100), 1 + static_cast<int>(random() % 800));
  }
  display_->resize(kWindow, 1, 1);
  pause(200);
  display_->resize(kWindow, 900, 600);
  display_->set_minimised(kWindow, true);
  pause(400);
  display_->set_minimised(kWindow, false);
  pause(400);
  press("s");
  pause(300);
  ASSERT_TRUE(alive()) << running_->standard_error();
  display_->close(kWindow);
  ASSERT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
  const nlohmann::json done = summary();
  EXPECT_GT(done["frames"], 50);
  EXPECT_GT(done["pictures_extracted"], 0);
  // By S; the keyboard, going into the panels, may have begun at their button.
  EXPECT_GE(done["pictures_written"], 1);
  EXPECT_LE(done["pictures_written"], 2);
  EXPECT_EQ(done["objects_left"], 0) << "OpenGL objects were not given back";
  // Pipelines and overlays make some when first needed; one for every frame or picture would be hundreds.
  EXPECT_LT(done["objects_grown"], 80) << "OpenGL objects became more while the viewer ran";
}

TEST_F(ViewerSession, ShowsSomethingBeforeAllIsPrepared) {
  // As much to prepare as for the whole recording: model and textures are the same.
  GenerateOptions generate;
  generate.name = "workcell";
  generate.pictures = 4;
  generate.scale = 0.33;
  generate_recording(generate, recording_ / "workcell");
  using Clock = std::chrono::steady_clock;
  const auto begun = Clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
  running_.emplace(std::vector<std::string>{"view", (recording_ / "workcell").string(), "--loop", "--json",
                                            (out_ / "summary.json").string()},
                   std::map<std::string, std::string>{{"DISPLAY", display_->name()}});
  // Something is to be seen when the window has more than one colour.
  const auto shows_something = [&] {
    const cv::Mat picture = display_->screenshot(kWindow);
    cv::Scalar mean, deviation;
    if (!picture.empty()) cv::meanStdDev(picture, mean, deviation);
    return deviation[0] + deviation[1] + deviation[2] > 10;
  };
  while (!shows_something() && passed() < kPatience) pause(20);
  const double seen_after = passed();
  // Reached in 0.6 s where nothing else runs; tests run beside each other, also on slower machines.
  EXPECT_LT(seen_after, 3.0) << "nothing is to be seen for too long";
  ASSERT_TITLE_COMES("| 0.1");  // it plays, so all has been prepared
  press("q");
  ASSERT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
  const double said = summary()["first_frame_after_seconds"];
  EXPECT_GT(said, 0.05);
  EXPECT_LT(said, seen_after + 0.1);
}

TEST_F(ViewerSession, PanelsAndPictureAreTwiceAsLargeOnAScreenOfTwiceTheDensity) {
  const auto picture_at = [&](int dots) {
    display_.emplace(2000, 1200);
    display_->set_dots_per_inch(dots);
    start({"--speed", "100"});
    wait_for_title("| end");
    for (int i = 0; i < 50; ++i) {
      pause(100);
      const std::string title = display_->title(kWindow).value_or("");
      if (title.size() > 5 && title.substr(title.size() - 5) == "| end") break;
    }
    pause(300);
    cv::Mat picture = display_->screenshot(kWindow);
    press("q");
    EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
    return picture;
  };
  const cv::Mat once = picture_at(96), twice = picture_at(192);
  ASSERT_FALSE(once.empty() || twice.empty());
  // Of the panels, what has no letters: their ground begins where the picture ends, and reaches below it.
  const auto panel_width = [](const cv::Mat& picture) {
    const cv::Vec3b ground = picture.at<cv::Vec3b>(picture.rows - 2, picture.cols - 2);
    int width = 0;
    while (width < picture.cols && picture.at<cv::Vec3b>(2, picture.cols - 1 - width) == ground) ++width;
    return width;
  };
  EXPECT_EQ(panel_width(once), 323);   // round(21.5 x 15)
  EXPECT_EQ(panel_width(twice), 645);  // 21.5 x 30
  EXPECT_EQ(once.cols - 323, 600) << "five times as large as the camera's picture";
  EXPECT_EQ(twice.cols - 645, 1200) << "ten times";
}

TEST_F(ViewerSession, FillsTheScreenAndGoesBack) {
  start({"--loop"});
  ASSERT_TITLE_COMES("| 0.");
  const auto becomes = [&](const cv::Size& size) {
    cv::Mat picture;
    for (int i = 0; i < 100 && picture.size() != size; ++i) {
      pause(50);
      picture = display_->screenshot(kWindow);
    }
    return picture.size() == size;
  };
  pause(300);
  const cv::Size before = display_->screenshot(kWindow).size();
  ASSERT_LT(before.width, 1100);
  press("F11");
  EXPECT_TRUE(becomes({1100, 800})) << display_->screenshot(kWindow).size();
  press("F11");
  EXPECT_TRUE(becomes(before)) << display_->screenshot(kWindow).size();
  press("q");
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
}

TEST_F(ViewerSession, KeysWorkAfterAClickIntoAPanel) {
  start({"--loop"});
  ASSERT_TITLE_COMES("| 0.");
  display_->drag_mouse(kWindow, 1, {760, 304}, {919, 304});
  ASSERT_TITLE_COMES("| delay 3000 ms |");
  press("space");
  ASSERT_TITLE_COMES("| paused");
  press("q");
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
}

TEST_F(ViewerSession, EscapeLeavesThePanelsBeforeTheProgram) {
  start({"--loop"});
  ASSERT_TITLE_COMES("| 0.");
  press("F2");
  pause(300);
  press("q");
  pause(500);
  EXPECT_TRUE(alive()) << "while the keyboard is in the panels, letters are theirs";
  press("Escape");
  pause(500);
  ASSERT_TRUE(alive()) << running_->standard_error();
  press("Escape");
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
}

TEST_F(ViewerSession, TheDisplayServerGoes) {
  start({"--loop", "--save-textures", (out_ / "textures").string()});
  ASSERT_TITLE_COMES("| 0.");
  pause(500);
  display_->kill_server();
  EXPECT_EQ(running_->wait(kPatience), 3) << running_->standard_error();
  EXPECT_NE(running_->standard_error().find("foreview: the display server is gone\n"), std::string::npos)
      << running_->standard_error();
  EXPECT_TRUE(fs::exists(out_ / "textures" / "textures.yaml")) << "what was asked to be kept is kept";
}

TEST_F(ViewerSession, TheWindowIsDestroyed) {
  start({"--loop"});
  ASSERT_TITLE_COMES("| 0.");
  display_->destroy_window(kWindow);
  EXPECT_EQ(running_->wait(kPatience), 3) << running_->standard_error();
  EXPECT_EQ(running_->standard_error(), "foreview: the window was destroyed by another program\n");
}

TEST_F(ViewerSession, TheContextIsLostAndMadeAnew) {
  start({"--loop", "--json", (out_ / "summary.json").string()}, {{"FOREVIEW_LOSE_CONTEXT", "10"}});
  ASSERT_TITLE_COMES("| 0.");
  pause(2000);
  ASSERT_TITLE_COMES("| 0.");
  press("3");
  ASSERT_TITLE_COMES("| both |");
  press("q");
  ASSERT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
  EXPECT_EQ(summary()["contexts_lost"], 1);
  EXPECT_GT(summary()["frames"], 10);
}

TEST_F(ViewerSession, TheRecordingIsDeletedWhilePlaying) {
  start({"--loop"});
  ASSERT_TITLE_COMES("| 0.");
  fs::remove_all(recording_ / "wall");
  pause(1500);
  ASSERT_TRUE(alive()) << running_->standard_error();
  press("space");
  ASSERT_TITLE_COMES("| paused");
  press("Left");
  press("q");
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
}

}  // namespace
}  // namespace foreview
