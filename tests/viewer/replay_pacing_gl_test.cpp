// `foreview replay --headless --rate`, as a user runs it. How punctual frames are is for benchmarks; here: what is
// said.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "support/slow_build.h"
#include "support/temporary_directory.h"
#include "viewer/run_foreview.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ReplayPacing : public ::testing::Test {
 protected:
  ReplayPacing() { test::WallRecording::write(recording_, 16); }
  [[nodiscard]] json read() const {
    std::ifstream stream(file_);
    return json::parse(stream);
  }
  void expect_refused(std::vector<std::string> options, const std::string& mentions) const {
    std::vector<std::string> arguments{"replay", recording_.string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const test::Finished run = test::run_foreview(arguments);
    EXPECT_EQ(run.status, 2) << run.err;
    const std::size_t error = run.err.find("foreview: ");
    ASSERT_NE(error, std::string::npos) << run.err;
    EXPECT_EQ(run.err.find('\n', error), run.err.size() - 1) << "one line, the last: " << run.err;
    EXPECT_NE(run.err.find(mentions, error), std::string::npos) << run.err;
  }
  static void expect_frames_in_order(const json& run) {
    double last = 0;
    std::uint64_t picture = 0;
    for (const json& frame : run["frames"]) {
      EXPECT_GT(frame["due_ms"], last);
      last = frame["due_ms"];
      EXPECT_LT(frame["start_ms"], frame["completion_ms"]);
      EXPECT_GE(frame["picture"], picture);
      picture = frame["picture"];
    }
    EXPECT_EQ(run["frames"].size(), run["frames_drawn"]);
  }
  test::TemporaryDirectory directory_;
  const fs::path recording_ = directory_.path() / "wall", file_ = directory_.path() / "pacing.json";
};

TEST_F(ReplayPacing, GoesOverTheLinkThatIsAskedFor) {
  const std::string duration = test::kIsSlowBuild ? "15s" : "2s";
  const std::vector<std::string> options{"replay",  recording_.string(), "--headless",  "--rate",
                                         "40",      "--duration",        duration,      "--size",
                                         "160x120", "--pacing",          file_.string()};
  ASSERT_EQ(test::run_foreview(options).status, 0);
  EXPECT_GT(read()["runs"][0]["pictures_extracted"], 0);
  auto lossy = options;
  lossy.insert(lossy.end(), {"--loss", "100%"});
  ASSERT_EQ(test::run_foreview(lossy).status, 0);
  EXPECT_EQ(read()["runs"][0]["pictures_extracted"], 0) << "all are lost";
}

TEST_F(ReplayPacing, RunsInRealTimeWhereAskedAndAllowed) {
  const test::Finished finished =
      test::run_foreview({"replay", recording_.string(), "--headless", "--rate", "40", "--duration", "1s", "--size",
                          "160x120", "--realtime", "--pacing", file_.string()});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const bool is_realtime = read()["realtime"];
  EXPECT_EQ(finished.err.find("--realtime: ") == std::string::npos, is_realtime)
      << "a warning where it is refused: " << finished.err;
  EXPECT_EQ(finished.out.find("in real time") != std::string::npos, is_realtime) << finished.out;
}

TEST_F(ReplayPacing, RecordsEveryFrameAndPicture) {
  const test::Finished finished =
      test::run_foreview({"replay", recording_.string(), "--headless", "--rate", "40", "--duration", "3s", "--delay",
                          "100ms", "--size", "160x120", "--pacing", file_.string()});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_NE(finished.out.find("frames: "), std::string::npos) << finished.out;
  const json report = read();
  EXPECT_EQ(report["width"], 160);
  EXPECT_NEAR(report["delay_seconds"].get<double>(), 0.1, 1e-9);
  ASSERT_EQ(report["runs"].size(), 1U);
  const json& run = report["runs"][0];
  EXPECT_GE(run["seconds"], 3.0);
  EXPECT_NEAR(run["rate_wanted"].get<double>(), 40, 1e-6);
  EXPECT_GT(run["frames_drawn"], 0);
  expect_frames_in_order(run);
  // Shorter than the run: it begins anew.
  EXPECT_GE(run["restarts"], 1);
  EXPECT_GT(run["pictures_extracted"], 0);
  EXPECT_GT(run["slices"], 0);
  for (const json& picture : run["pictures"]) {
    EXPECT_LE(picture["begun_ms"], picture["finished_ms"]);
    EXPECT_LE(picture["finished_ms"], picture["displayed_ms"]);
    EXPECT_GE(picture["displayed_after_capture_ms"], 100) << "before it had come";
  }
  EXPECT_GT(run["intervals"].back()["resident_bytes"], 0);
}

TEST_F(ReplayPacing, MeasuresReferencesBefore) {
  const test::Finished finished =
      test::run_foreview({"replay", recording_.string(), "--headless", "--rate", "30", "--duration", "1s", "--size",
                          "160x120", "--reference", "--back-to-back", "--pacing", file_.string()});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const json report = read();
  ASSERT_EQ(report["runs"].size(), 3U);
  EXPECT_EQ(report["runs"][0]["frames_drawn"], 0);
  EXPECT_GT(report["runs"][0]["pictures_extracted"], 0);
  EXPECT_GT(report["runs"][1]["frames_drawn"], 0);
  EXPECT_EQ(report["runs"][1]["pictures_extracted"], 0);
  EXPECT_EQ(report["runs"][1]["slices"], 0);
  EXPECT_GT(report["runs"][2]["frames_drawn"], 0);
  EXPECT_GT(report["runs"][2]["pictures_extracted"], 0);
  for (const json& run : report["runs"]) expect_frames_in_order(run);
  const double punctual = report["part_as_punctual_as_alone"], rate = report["part_of_picture_rate_alone"];
  EXPECT_TRUE(punctual >= 0 && punctual <= 1) << punctual;
  EXPECT_GT(rate, 0);
}

TEST_F(ReplayPacing, GoesOnWhenTheRecordingIsDeleted) {
  test::RunningForeview run({"replay", recording_.string(), "--headless", "--rate", "30", "--duration", "4s", "--size",
                             "160x120", "--delay", "0", "--pacing", file_.string()});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  fs::remove_all(recording_);
  const auto status = run.wait(60);
  ASSERT_TRUE(status) << "it hangs";
  EXPECT_EQ(*status, 0) << run.standard_error();
  EXPECT_NE(run.standard_error().find("warning: " + recording_.string()), std::string::npos) << run.standard_error();
  EXPECT_GT(read()["runs"][0]["frames_drawn"], 0);
}

TEST_F(ReplayPacing, CtrlCEndsItWithWhatThereIs) {
  test::RunningForeview run({"replay", recording_.string(), "--headless", "--rate", "30", "--duration", "1000s",
                             "--size", "160x120", "--pacing", file_.string()});
  std::this_thread::sleep_for(std::chrono::seconds(4));
  run.send_signal(SIGINT);
  const auto status = run.wait(60);
  ASSERT_TRUE(status) << "it hangs";
  EXPECT_EQ(*status, 130) << run.standard_error();
  EXPECT_EQ(read()["format"], "foreview-pacing");
}

TEST_F(ReplayPacing, RefusesWhatCannotBe) {
  expect_refused({"--headless", "--rate", "0"}, "--rate");
  expect_refused({"--headless", "--rate", "fast"}, "--rate");
  expect_refused({"--rate", "30"}, "--headless");
  expect_refused({"--headless", "--rate", "30", "--duration", "0"}, "--duration");
  expect_refused({"--headless", "--rate", "30", "--size", "800"}, "--size");
  expect_refused({"--headless", "--rate", "30", "--size", "0x600"}, "--size");
  expect_refused({"--headless", "--rate", "30", "--size", "100000x100000"}, "--size");
  expect_refused({"--headless", "--rate", "30", "--history", "3"}, "--history");
  expect_refused({"--headless", "--rate", "30", "--pacing", "/no/such/directory/file"}, "--pacing");
  expect_refused({"--headless", "--rate", "30", "--back-to-back", "--loss", "10%"}, "--back-to-back");
  expect_refused({"--headless", "--out", "pictures", "--loss", "10%"}, "--loss");
  expect_refused({"--headless", "--rate", "30", "--from", "2", "--to", "1"}, "--to");
}

}  // namespace
}  // namespace foreview
