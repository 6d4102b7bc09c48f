// `foreview replay --headless --rate`, as a user runs it. How punctual frames are is for benchmarks; here: what is
// said.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "calib/painted_room.h"
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

/// A walk through the painted room, one picture every 50 ms, whose recorded camera has another focal length and is not
/// quite where the poses are.
void write_badly_registered(const fs::path& directory, int pictures) {
  const test::PaintedRoom room;
  const CameraModel camera = test::pinhole(320, 240, 260);
  fs::create_directories(directory);
  write_obj(room.mesh(), directory / "scene.obj");
  RecordingWriter::Description description;
  description.name = "badly registered";
  CameraModel recorded_camera = camera;
  recorded_camera.focal_length *= 1.03;
  description.cameras = {{"", recorded_camera}};
  description.scene_file = "scene.obj";
  description.import_options.backdrop = false;
  description.density = 20;
  RecordingWriter writer(directory, description);
  const Pose recorded_from_true{glm::angleAxis(0.03, glm::normalize(glm::dvec3(0.3, 1, 0.2))), {0.03, -0.02, 0.02}};
  for (int i = 0; i < pictures; ++i) {
    const double t = i / 30.0;
    const glm::dvec3 eye(0.6 * std::sin(1.1 * t), 0.2 * std::sin(1.7 * t), -1.2 + 0.5 * std::sin(0.7 * t));
    const Pose truth = looking_at(eye, eye + glm::dvec3(0.6 * std::sin(0.8 * t), 0.2 * std::cos(t), 1), {0, -1, 0});
    const Timestamp stamp{1'000'000'000 + i * 50'000'000LL};
    writer.add_camera_pose(0, stamp, truth * recorded_from_true.inverse());
    writer.add_picture(0, stamp, room.picture(camera, truth), "png");
  }
  writer.finish();
}

TEST_F(ReplayPacing, CorrectsRegistrationBesideTheDisplay) {
  const fs::path recording = directory_.path() / "room";
  write_badly_registered(recording, 120);
  const std::vector<std::string> options{"replay",  recording.string(), "--headless",  "--rate",
                                         "20",      "--delay",          "100ms",       "--size",
                                         "160x120", "--pacing",         file_.string()};
  auto long_enough = options;
  long_enough.insert(long_enough.end(), {"--duration", test::kIsSlowBuild ? "90s" : "10s"});
  const test::Finished finished = test::run_foreview(long_enough);
  ASSERT_EQ(finished.status, 0) << finished.err;
  const json registration = read()["registration"];
  EXPECT_TRUE(registration["is_correcting"]) << registration;
  EXPECT_GT(registration["error_recorded"], 1.5) << registration;
  EXPECT_LT(registration["error_registered"], 0.5 * registration["error_recorded"].get<double>()) << registration;
  EXPECT_NE(finished.out.find(" px off, now "), std::string::npos) << finished.out;
  auto off = options;
  off.insert(off.end(), {"--duration", "1s", "--registration", "off"});
  ASSERT_EQ(test::run_foreview(off).status, 0);
  EXPECT_TRUE(read()["registration"].is_null());
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
