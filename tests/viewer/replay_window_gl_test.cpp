#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "support/slow_build.h"
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

constexpr double kPatience = 60;  // seconds, for a loaded machine
constexpr const char* kWindow = "foreview";

/// The real window on a virtual display. Skipped only where there is no Xvfb to show it on.
class ReplayWindow : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed: the window was NOT tested";
    display_.emplace(800, 600);
    WallRecording::write(recording_.path() / "wall", 16);
  }

  void start(std::vector<std::string> more) {
    std::vector<std::string> arguments{
        "replay", (recording_ / "wall").string(), "--delay", "120ms", "--out", out_.path().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    running_.emplace(arguments, std::map<std::string, std::string>{{"DISPLAY", display_->name()}});
  }

  std::string wait_for_title(const std::string& part) { return display_->wait_for_title(kWindow, part, kPatience); }
  bool wait_for_title_end(const std::string& end) {
    for (int i = 0; i < kPatience * 50 && !running_->wait(0.02); ++i) {
      const std::string title = display_->title(kWindow).value_or("");
      if (title.size() >= end.size() && title.compare(title.size() - end.size(), end.size(), end) == 0) return true;
    }
    return false;
  }
  void press(const std::string& key) { display_->press(kWindow, key); }

  std::vector<fs::path> saved() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(out_.path())) {
      if (entry.path().extension() == ".png") files.push_back(entry.path());
    }
    return files;
  }
  bool wait_for_saved(std::size_t count) {
    for (int i = 0; i < kPatience * 50 && saved().size() < count && !running_->wait(0.02); ++i) {
    }
    return saved().size() >= count;
  }

  TemporaryDirectory recording_, out_;
  std::optional<VirtualDisplay> display_;
  std::optional<RunningForeview> running_;
};

#define ASSERT_TITLE_COMES(part)                                                                             \
  do {                                                                                                       \
    const std::string title_seen = wait_for_title(part);                                                     \
    ASSERT_NE(title_seen.find(part), std::string::npos) << title_seen << "\n" << running_->standard_error(); \
  } while (false)

#define ASSERT_TITLE_ENDS(part) ASSERT_TRUE(wait_for_title_end(part)) << display_->title(kWindow).value_or("no window")

TEST_F(ReplayWindow, PlaysToTheEndAndQuits) {
  start({"--speed", "2"});
  ASSERT_TITLE_COMES("| end");
  const std::string title = display_->title(kWindow).value_or("");
  EXPECT_EQ(title.rfind("foreview: wall | predicted | 0.60 s | delay 120 ms | ", 0), 0U) << title;
  press("q");
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
  EXPECT_NE(running_->standard_output().find("Tab"), std::string::npos) << "the keys are explained";
}

TEST_F(ReplayWindow, WhatSSavesIsTheHeadlessPicture) {
  // So slowly that every picture is used, in the order in which headless replay uses them.
  start({"--speed", test::kIsSlowBuild ? "0.02" : "0.15", "--json", (out_ / "summary.json").string()});
  ASSERT_TITLE_COMES("| end");
  ASSERT_TITLE_ENDS("| end");
  press("s");
  ASSERT_TRUE(wait_for_saved(1)) << running_->standard_error();
  // After a step in time, textures are made anew from the newest picture backwards.
  press("Left");
  press("Left");
  ASSERT_TITLE_COMES("| 0.52 s");
  ASSERT_TITLE_ENDS("| paused");
  press("Tab");
  press("Tab");
  ASSERT_TITLE_COMES("| both |");
  press("m");
  press("h");
  press("w");
  press("s");
  ASSERT_TRUE(wait_for_saved(2)) << running_->standard_error();
  press("Escape");
  ASSERT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
  const nlohmann::json summary = nlohmann::json::parse(std::ifstream(out_ / "summary.json"));
  EXPECT_EQ(summary["pictures_overwritten"], 0) << "this machine is too slow for this test";

  const TemporaryDirectory headless;
  for (const std::vector<std::string>& view : std::vector<std::vector<std::string>>{
           {"--view", "predicted"}, {"--view", "both", "--edges", "--holes", "--wireframe"}}) {
    std::vector<std::string> arguments{"replay", (recording_ / "wall").string(), "--delay", "120ms", "--headless",
                                       "--out",  headless.path().string(),       "--quiet"};
    arguments.insert(arguments.end(), view.begin(), view.end());
    const test::Finished run = test::run_foreview(arguments);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  struct Case {
    const char* mode;
    const char* saved;
    std::size_t picture;
    double difference;
  };
  // Another order of pictures rounds colours differently.
  for (const Case& one : {Case{"predicted", "0.600s", 15, 0}, Case{"both", "0.520s", 13, 2}}) {
    std::vector<fs::path> pictures(fs::directory_iterator(headless / one.mode), fs::directory_iterator{});
    std::sort(pictures.begin(), pictures.end());
    ASSERT_EQ(pictures.size(), 16U);
    const cv::Mat expected = cv::imread(pictures[one.picture].string());
    const cv::Mat actual =
        cv::imread((out_ / ("foreview-wall-" + std::string(one.mode) + "-" + one.saved + ".png")).string());
    ASSERT_EQ(actual.size(), expected.size()) << one.mode;
    EXPECT_LE(cv::norm(actual, expected, cv::NORM_INF), one.difference) << one.mode;
  }
}

TEST_F(ReplayWindow, ShowsTheFrameUprightWithItsAspectKept) {
  start({"--speed", "100", "--view", "delayed"});
  ASSERT_TITLE_COMES("| end");
  for (const cv::Size size : {cv::Size(360, 240), cv::Size(500, 240), cv::Size(240, 400)}) {
    display_->resize(kWindow, size.width, size.height);
    const double scale = std::min(size.width / 120.0, size.height / 80.0);
    const cv::Rect frame((size.width - static_cast<int>(120 * scale)) / 2,
                         (size.height - static_cast<int>(80 * scale)) / 2, static_cast<int>(120 * scale),
                         static_cast<int>(80 * scale));
    cv::Mat expected(size, CV_8UC3, cv::Scalar::all(0));
    cv::Mat inside = expected(frame);
    cv::resize(WallRecording::truth(11), inside, frame.size(), 0, 0, cv::INTER_LINEAR);
    cv::Mat shown;
    double difference = 255;
    for (int i = 0; i < kPatience * 20 && difference > 3; ++i) {
      ASSERT_FALSE(running_->wait(0.05)) << running_->standard_error();
      shown = display_->screenshot(kWindow);
      if (shown.size() == size) difference = cv::norm(shown, expected, cv::NORM_INF);
    }
    EXPECT_LE(difference, 3) << size << " shows " << shown.size();
  }
  press("q");
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
}

TEST_F(ReplayWindow, PausesAndGoesOn) {
  start({"--speed", "0.02"});
  ASSERT_TITLE_COMES("| 0.0");
  press("space");
  ASSERT_TITLE_COMES("| paused");
  press("Right");
  press("Right");
  ASSERT_TITLE_COMES("| 0.08 s");
  press("space");
  const std::string title = wait_for_title("| 0.09 s");
  EXPECT_EQ(title.find("paused"), std::string::npos) << title;
  display_->close(kWindow);
  EXPECT_EQ(running_->wait(kPatience), 0) << running_->standard_error();
}

TEST_F(ReplayWindow, CtrlCEndsIt) {
  start({"--loop"});
  ASSERT_TITLE_COMES("| 0.");
  running_->send_signal(SIGINT);
  EXPECT_EQ(running_->wait(kPatience), 130) << running_->standard_error();
}

}  // namespace
}  // namespace foreview
