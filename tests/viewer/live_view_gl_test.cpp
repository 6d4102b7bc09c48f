// `foreview view` on live streams, as a user runs it beside `foreview send`: each in a process of its own, over DDS on
// loopback.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <random>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "foreview/server/dds/dds_node.h"
#include "foreview/server/frame_source.h"
#include "server/dds_test_domain.h"
#include "support/slow_build.h"
#include "support/temporary_directory.h"
#include "viewer/run_foreview.h"
#include "viewer/small_recording.h"
#include "viewer/virtual_display.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::RunningForeview;
using test::SmallSite;
using test::WallRecording;

constexpr double kPatience = 60;  // seconds, for a loaded machine
constexpr const char* kWindow = "foreview";

void pause(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// SmallSite seen by two cameras at once, each with its own picture size, focal length, rate and phase, so slowly that
/// every picture is used before the next one comes.
class TwoCameras {
 public:
  static constexpr int kLeft = 5, kRight = 3;
  static constexpr Duration kPoses{20'000'000};
  /// After the first one of each, for which shaders are made, there is time.
  static Timestamp left(int i) {
    return SmallSite::stamp(0) + Duration{i == 0 ? 0 : 2'500'000'000 + i * 700'000'000LL};
  }
  static Timestamp right(int i) { return SmallSite::stamp(0) + Duration{1'300'000'000 + i * 2'200'000'000LL}; }

  static void write(const fs::path& directory, bool has_right = true) {
    SmallSite left_site, right_site;
    right_site.camera.width = 128;
    right_site.camera.height = 80;
    right_site.camera.focal_length = {70, 70};
    right_site.camera.principal_point = {60, 41};
    right_site.camera.distortion_model = DistortionModel::plumb_bob;
    right_site.camera.distortion = {-0.1, 0.02};
    RecordingWriter::Description description;
    description.name = "two";
    description.cameras.push_back({"left", left_site.camera});
    if (has_right) description.cameras.push_back({"right", right_site.camera});
    description.scene_file = "scene.obj";
    description.import_options.backdrop = false;
    RecordingWriter writer(directory, description);
    write_obj(SmallSite::mesh(), directory / description.scene_file);
    const std::size_t cameras = has_right ? 2 : 1;
    for (int i = 0; i <= 300; ++i) {
      const Timestamp t = SmallSite::stamp(0) + Duration{i * kPoses.nanoseconds};
      writer.add_part_pose("board", t, board(t));
      for (std::size_t c = 0; c < cameras; ++c) writer.add_camera_pose(c, t, camera(c, t));
    }
    for (int i = 0; i < kLeft; ++i) writer.add_picture(0, left(i), left_site.render(0, moment(left(i))), "jpg");
    for (int i = 0; has_right && i < kRight; ++i) {
      writer.add_picture(1, right(i), right_site.render(1, moment(right(i))), "jpg");
    }
    writer.finish();
  }

 private:
  /// SmallSite's second of movement takes six.
  static Timestamp moment(Timestamp t) {
    return SmallSite::stamp(0) + Duration{(t - SmallSite::stamp(0)).nanoseconds / 6};
  }
  static Pose board(Timestamp t) { return SmallSite::world_from_board(moment(t)); }
  static Pose camera(std::size_t c, Timestamp t) { return SmallSite::world_from_camera(c, moment(t)); }
};

class LiveView : public ::testing::Test {
 protected:
  std::vector<std::string> network() const { return {"--domain", std::to_string(domain_)}; }
  static std::vector<std::string> join(std::vector<std::string> first, const std::vector<std::string>& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  }
  /// Sends when somebody hears all of it.
  std::unique_ptr<RunningForeview> send(const fs::path& recording, const std::vector<std::string>& more = {}) const {
    return std::make_unique<RunningForeview>(join(join({"send", recording.string(), "--wait"}, network()), more));
  }
  static std::vector<std::string> topics(const std::vector<std::string>& cameras) {
    std::vector<std::string> arguments;
    for (const std::string& camera : cameras) {
      arguments.insert(arguments.end(), {"--topic", "/" + camera + "/image_raw/compressed"});
    }
    return arguments;
  }
  std::unique_ptr<RunningForeview> view(const fs::path& scene, const std::vector<std::string>& more,
                                        const std::map<std::string, std::string>& environment = {}) const {
    return std::make_unique<RunningForeview>(
        join(join({"view", "--scene", scene.string(), "--json", json_.string()}, network()), more), environment);
  }
  [[nodiscard]] json summary() const { return json::parse(std::ifstream(json_)); }
  static std::size_t picture_count(const json& camera, const char* what) { return camera[what].get<std::size_t>(); }
  /// `unfinished`: what may be waiting to be decoded or taken at the end, where pictures come to the last.
  static void expect_balance(const json& camera, std::size_t unfinished = 0) {
    const std::size_t in = picture_count(camera, "pictures_in");
    const std::size_t counted = picture_count(camera, "pictures_used") + picture_count(camera, "pictures_overwritten") +
                                picture_count(camera, "pictures_damaged") + picture_count(camera, "pictures_stateless");
    EXPECT_LE(counted, in) << camera;
    EXPECT_GE(counted + unfinished, in) << camera;
  }
  static std::size_t arrived_or_counted(const json& camera) {
    return picture_count(camera, "pictures_in") + picture_count(camera, "pictures_duplicated") +
           picture_count(camera, "pictures_lost_on_network");
  }

  const int domain_ = test::dds_domain();
  test::TemporaryDirectory directory_;
  const fs::path recording_ = directory_.path() / "recording", out_ = directory_.path() / "out",
                 json_ = directory_.path() / "live.json", pacing_ = directory_.path() / "pacing.json";
};

TEST_F(LiveView, EveryPictureArrivesOrIsCounted) {
  WallRecording::write(recording_, 40);
  const auto sender = send(recording_);
  const auto viewer = view(recording_, join(topics({"camera"}), {"--headless", "--until-silent", "2s"}));
  ASSERT_EQ(sender->wait(kPatience), 0) << sender->standard_error();
  ASSERT_EQ(viewer->wait(kPatience), 0) << viewer->standard_error();
  EXPECT_NE(sender->standard_error().find("40 pictures sent"), std::string::npos) << sender->standard_error();
  const json done = summary();
  const json& camera = done["cameras"][0];
  EXPECT_EQ(camera["name"], "camera");
  EXPECT_EQ(arrived_or_counted(camera), 40U) << camera;
  expect_balance(camera);
  EXPECT_GT(camera["pictures_used"], 0);
  EXPECT_GT(done["pictures_displayed"], 0);
  EXPECT_EQ(done["clock"]["mode"], "estimated");
  EXPECT_GT(done["latency_ms"]["capture_to_display_median"], 0);
  EXPECT_LT(done["latency_ms"]["capture_to_display_median"], 10'000);
  EXPECT_NE(viewer->standard_output().find("capture to display"), std::string::npos) << viewer->standard_output();
}

TEST_F(LiveView, SomeSecondsOfTheKitchen) {
  const fs::path kitchen = fs::path(FOREVIEW_SHARED_DIR) / "recordings" / "kitchen";
  if (!fs::exists(kitchen / "scene.ply")) GTEST_SKIP() << kitchen << " is not there: a real robot was NOT tested";
  const auto viewer =
      view(kitchen,
           join(topics({"kitchen"}), {"--headless", "--until-silent", "4s", "--out", out_.string(), "--every", "10"}));
  const auto sender = send(kitchen, {"--loop"});
  // Importing the model takes its time.
  const std::regex something("kitchen: [1-9][0-9]* in");
  for (int i = 0; i < kPatience * 10 && !std::regex_search(viewer->standard_error(), something); ++i) pause(0.1);
  pause(4);
  sender->send_signal(SIGINT);
  ASSERT_EQ(sender->wait(kPatience), 130) << sender->standard_error();
  ASSERT_EQ(viewer->wait(kPatience), 0) << viewer->standard_error();
  const std::string log = sender->standard_error();
  const std::size_t end = log.find(" pictures sent");
  ASSERT_NE(end, std::string::npos) << log;
  const std::size_t sent = std::stoul(log.substr(log.rfind(' ', end - 1) + 1));
  EXPECT_GT(sent, 30U);
  const json done = summary();
  EXPECT_EQ(arrived_or_counted(done["cameras"][0]), sent) << done["cameras"];
  expect_balance(done["cameras"][0]);
  ASSERT_GE(done["saved"].size(), 1U) << done;
  cv::Scalar mean, deviation;
  cv::meanStdDev(cv::imread(done["saved"].back()["file"].get<std::string>()), mean, deviation);
  EXPECT_GT(deviation[1], 20) << "the frame shows nothing";
}

TEST_F(LiveView, TwoCamerasGiveTheSameImagesAsAReplay) {
  TwoCameras::write(recording_);
  const auto sender = send(recording_, {"--recorded-stamps", "--reliable"});
  const auto viewer =
      view(recording_, join(topics({"left", "right"}),
                            {"--delay", "150ms", "--headless", "--until-silent", "2s", "--out", out_.string()}));
  ASSERT_EQ(sender->wait(kPatience), 0) << sender->standard_error();
  ASSERT_EQ(viewer->wait(kPatience), 0) << viewer->standard_error();
  if (test::kIsSlowBuild) GTEST_SKIP() << "not every picture is used in time: images were NOT compared";
  const json done = summary();
  ASSERT_EQ(done["cameras"].size(), 2U);
  const std::map<std::string, std::size_t> sent{{"left", TwoCameras::kLeft}, {"right", TwoCameras::kRight}};
  for (const json& camera : done["cameras"]) {
    ASSERT_EQ(camera["pictures_used"], sent.at(camera["name"]))
        << "pictures were not all used; this machine is too slow for this test: " << camera;
  }
  ASSERT_EQ(done["saved"].size(), TwoCameras::kLeft);

  // The same pictures, whatever they are, at the same time.
  std::size_t at_samples = 0, with_right = 0;
  for (const json& saved : done["saved"]) {
    EXPECT_EQ(saved["level"], "fresh") << saved;
    Timestamp state, newest;
    ASSERT_TRUE(Timestamp::parse_seconds(saved["state"].get<std::string>(), state));
    for (const json& picture : saved["pictures"]) {
      Timestamp captured;
      ASSERT_TRUE(Timestamp::parse_seconds(picture["captured"].get<std::string>(), captured));
      newest = std::max(newest, captured);
      with_right += picture["camera"] == "right" ? 1 : 0;
    }
    const Duration delay = state - newest + Duration{-1};
    const std::string at = std::to_string((state - SmallSite::stamp(0)).nanoseconds / 1'000) + "us";
    const fs::path frames = directory_.path() / ("replayed-" + std::to_string(at_samples));
    // Poses are known in whole microseconds here, unless one between two samples was shown.
    if (state.nanoseconds % TwoCameras::kPoses.nanoseconds != 0) continue;
    ++at_samples;
    const test::Finished replayed =
        test::run_foreview({"replay", recording_.string(), "--headless", "--out", frames.string(), "--at", at,
                            "--delay", Timestamp{delay.nanoseconds}.to_string() + "s"});
    ASSERT_EQ(replayed.status, 0) << replayed.err;
    const auto file = fs::directory_iterator(frames / "predicted");
    const cv::Mat expected = cv::imread(file->path().string());
    const cv::Mat actual = cv::imread(saved["file"].get<std::string>());
    ASSERT_FALSE(expected.empty());
    ASSERT_EQ(actual.size(), expected.size());
    EXPECT_EQ(cv::norm(actual, expected, cv::NORM_INF), 0) << saved << " differs from a replay's at " << at;
    EXPECT_GT(cv::mean(actual)[1], 20) << "it shows something";
  }
  EXPECT_GE(at_samples, 3U) << "too few frames show poses that the recording has";
  EXPECT_GE(with_right, 3U);
}

/// What the frame's border says.
std::string border_of(const fs::path& file) {
  const cv::Mat frame = cv::imread(file.string());
  if (frame.empty()) return "no frame";
  const auto& pixel = frame.at<cv::Vec3b>(1, 1);
  const auto is = [&](int blue, int green, int red) {
    return std::abs(pixel[0] - blue) <= 2 && std::abs(pixel[1] - green) <= 2 && std::abs(pixel[2] - red) <= 2;
  };
  return is(89, 0, 184) ? "silent" : is(15, 26, 219) ? "stale" : "none";
}

/// A publisher that knows the topics' names and types, and nothing else.
void send_garbage(int domain, const std::string& image, double seconds) {
  DdsNode node({domain});
  const auto pictures = node.advertise<CompressedImageMessage>(image, QosProfile::sensor_data);
  const auto info = node.advertise<CameraInfoMessage>("/camera/camera_info", QosProfile::sensor_data);
  const auto tf = node.advertise<TransformMessage>("/tf", QosProfile::transforms);
  std::mt19937 random(5);
  const Timestamp end = steady_now() + Duration::from_seconds(seconds);
  for (int i = 0; steady_now() < end; ++i) {
    // Most as a broken camera would; now and then a stamp of its own.
    const Timestamp now{
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
            .count()};
    const Timestamp stamp = i % 50 == 49 ? Timestamp{static_cast<std::int64_t>(random()) * 1'000'000'000} : now;
    CompressedImageMessage picture{{stamp, "camera_optical_frame"}, "jpeg", {}};
    picture.data.resize(random() % 60'000);
    for (auto& byte : picture.data) byte = static_cast<std::uint8_t>(random());
    pictures->write(picture);
    CameraInfoMessage model;
    model.width = static_cast<std::uint32_t>(random() % 3);
    info->write(model);
    Pose pose;
    pose.translation.x = std::nan("");
    tf->write({{{{Timestamp{static_cast<std::int64_t>(random())}, "world"}, "camera_optical_frame", pose}}});
    pause(0.01);
  }
}

TEST_F(LiveView, TheDisplayNeverStops) {
  WallRecording::write(recording_, 50);
  const auto viewer =
      view(recording_, join(topics({"camera"}), {"--headless", "--rate", "20", "--duration", "26s", "--every", "500ms",
                                                 "--out", out_.string(), "--pacing", pacing_.string()}));
  pause(1);
  auto sender = send(recording_, {"--loop"});
  pause(6);
  sender->send_signal(SIGKILL);
  ASSERT_EQ(sender->wait(kPatience), 128 + SIGKILL);
  pause(5);
  sender = send(recording_, {"--loop"});
  pause(5);
  send_garbage(domain_, "/camera/image_raw/compressed", 3);
  ASSERT_FALSE(viewer->wait(0.01)) << viewer->standard_error();
  ASSERT_EQ(viewer->wait(kPatience), 0) << viewer->standard_error();
  sender->send_signal(SIGINT);
  if (test::kIsSlowBuild) GTEST_SKIP() << "whether frames kept coming was NOT tested";

  // Frames kept coming, whatever happened to the sender. How punctually is for benchmarks.
  const json run = json::parse(std::ifstream(pacing_))["runs"][0];
  double last = 0;
  std::map<int, int> frames_in_second;
  for (const json& frame : run["frames"]) {
    const double completed = frame["completion_ms"].get<double>() * 1e-3;
    EXPECT_LT(completed - last, 2) << "no frame for so long at " << last << " s";
    last = completed;
    ++frames_in_second[static_cast<int>(completed)];
  }
  EXPECT_GT(last, 25);
  for (int second = 1; second < 25; ++second) EXPECT_GE(frames_in_second[second], 3) << "in second " << second;

  // Fresh, then silent, then fresh again; the frames themselves say so.
  const json done = summary();
  std::vector<std::string> levels;
  for (const json& phase : done["staleness"]) {
    const std::string level = phase["level"];
    if (level != "ageing" && level != "stale") levels.push_back(level);
  }
  EXPECT_GE(std::count(levels.begin(), levels.end(), "silent"), 1) << done["staleness"];
  std::map<std::string, int> seen;
  bool was_fresh = false, fell_silent = false, came_back = false;
  for (const json& saved : done["saved"]) {
    const std::string border = border_of(saved["file"].get<std::string>()), level = saved["level"];
    EXPECT_EQ(border, level == "silent" || level == "stale" ? level : "none") << saved;
    ++seen[level];
    if (saved["pictures"].empty()) continue;
    if (level == "fresh") {
      was_fresh = true;
      came_back = came_back || fell_silent;
      EXPECT_EQ(saved["text"], "");
    } else if (level == "silent") {
      fell_silent = fell_silent || was_fresh;
      EXPECT_EQ(saved["text"].get<std::string>().rfind("LINK SILENT for ", 0), 0U) << saved;
    }
  }
  EXPECT_TRUE(was_fresh && fell_silent && came_back) << json(seen);
  const json& camera = done["cameras"][0];
  EXPECT_GT(camera["pictures_damaged"], 20) << "the garbage was not noticed: " << camera;
  expect_balance(camera, 3);
}

TEST_F(LiveView, ConnectsToAServerThatDecodesElsewhere) {
  WallRecording::write(recording_, 40);
  // The server goes on publishing what it has; the display must be there first.
  const auto viewer = view(recording_, {"--connect", "camera", "--headless", "--until-silent", "2s", "--out",
                                        out_.string(), "--every", "5"});
  pause(1);
  RunningForeview server(join(join({"serve", "--republish", "--duration", "20s"}, topics({"camera"})), network()));
  pause(1);
  const auto sender = send(recording_);
  ASSERT_EQ(sender->wait(kPatience), 0) << sender->standard_error();
  ASSERT_EQ(viewer->wait(kPatience), 0) << viewer->standard_error();
  const json done = summary();
  const json& camera = done["cameras"][0];
  EXPECT_EQ(camera["name"], "camera");
  EXPECT_EQ(camera["topic"], "/foreview/camera/image_raw");
  expect_balance(camera);
  EXPECT_GT(camera["pictures_used"], test::kIsSlowBuild ? 0 : 5) << camera;
  ASSERT_GE(done["saved"].size(), 1U);
  EXPECT_GT(cv::mean(cv::imread(done["saved"].back()["file"].get<std::string>()))[1], 20);
}

TEST_F(LiveView, RefusesWhatALiveStreamCannotDo) {
  WallRecording::write(recording_, 2);
  const std::string scene = recording_.string(), topic = "/camera/image_raw/compressed";
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"view"}, "expected a recording, or --topic or --connect"},
      {{"view", "--topic", topic}, "--scene"},
      {{"view", scene, "--topic", topic}, "cannot both be shown"},
      {{"view", "--topic", topic, "--scene", scene, "--from", "3"}, "--from: a live stream begins now"},
      {{"view", "--topic", topic, "--scene", scene, "--speed", "2"}, "--speed"},
      {{"view", "--topic", topic, "--scene", scene, "--loop"}, "--loop"},
      {{"view", "--topic", topic, "--scene", scene, "--camera", "no"}, "none of the cameras heard: camera"},
      {{"view", "--topic", topic, "--scene", "no.obj", "--headless"}, "no such file"},
      {{"view", "--topic", "a b", "--scene", scene, "--headless"}, "is no name of a ROS 2 topic"},
      {{"view", "--connect", "left", "--scene", scene, "--domain", "500", "--headless"}, "--domain"},
      {{"view", scene, "--headless"}, "foreview replay --headless"},
      {{"view", scene, "--until-silent", "2s"}, "expected --topic or --connect"},
      {{"view", "--topic", topic, "--scene", scene, "--headless", "--every", "0"}, "--every"},
      {{"view", "--topic", topic, "--scene", scene, "--headless", "--duration", "-1s"}, "--duration"},
      {{"view", "--topic", topic, "--scene", scene, "--headless", "--size", "12"}, "--size"},
  };
  for (const auto& [arguments, expected] : cases) {
    const test::Finished run = test::run_foreview(arguments);
    EXPECT_EQ(run.status, 2) << run.err;
    const std::size_t error = run.err.find("foreview: ");
    ASSERT_NE(error, std::string::npos) << run.err;
    EXPECT_EQ(run.err.find('\n', error), run.err.size() - 1) << "one line, the last: " << run.err;
    EXPECT_NE(run.err.find(expected, error), std::string::npos) << run.err;
  }
}

TEST_F(LiveView, CtrlCEndsItWithItsSummaryWritten) {
  WallRecording::write(recording_, 2);
  const auto viewer = view(recording_, join(topics({"camera"}), {"--headless"}));
  pause(3);
  viewer->send_signal(SIGINT);
  EXPECT_EQ(viewer->wait(kPatience), 130) << viewer->standard_error();
  const json done = summary();
  EXPECT_GT(done["frames"], 0);
  EXPECT_NE(done["missing"].get<std::string>().find("nobody publishes /camera/image_raw/compressed"),
            std::string::npos);
}

/// The window, on a virtual display.
class LiveWindow : public LiveView {
 protected:
  void SetUp() override {
    if (!test::VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed: the window was NOT tested";
    display_.emplace(1100, 800);
    WallRecording::write(recording_, 50);
  }
  bool title_comes(const std::string& part) {
    const std::string title = display_->wait_for_title(kWindow, part, kPatience);
    return title.find(part) != std::string::npos;
  }
  std::optional<test::VirtualDisplay> display_;
};

TEST_F(LiveWindow, OpensShowsPicturesAndClosesWhenTheSenderIsGone) {
  const auto viewer =
      view(recording_, join(topics({"camera"}), {"--out", out_.string(), "--quiet"}), {{"DISPLAY", display_->name()}});
  ASSERT_TRUE(title_comes("| live | no picture yet")) << viewer->standard_error();
  auto sender = send(recording_, {"--loop"});
  ASSERT_TRUE(title_comes(" old | ")) << viewer->standard_error();
  pause(1);
  // What nobody can do live is refused without harm, and the rest works.
  for (const char* key :
       {"space", "Left", "Right", "Home", "End", "minus", "equal",        "l",          "2", "3", "4", "5",
        "1",     "a",    "h",     "c",    "c",   "r",     "bracketright", "bracketleft"}) {
    display_->press(kWindow, key);
    pause(0.1);
  }
  display_->press(kWindow, "2");
  pause(0.5);
  // The picture at the left of the panels is what the camera sees: colourful.
  cv::Scalar mean, deviation;
  for (int i = 0; i < 20 && deviation[1] <= 15; ++i) {
    if (i > 0) pause(0.5);
    ASSERT_FALSE(viewer->wait(0.01)) << viewer->standard_error();
    const cv::Mat shown = display_->screenshot(kWindow);
    ASSERT_FALSE(shown.empty());
    cv::imwrite(std::string(FOREVIEW_TEST_OUTPUT_DIR) + "/live-window.png", shown);
    cv::meanStdDev(shown(cv::Rect(100, 100, 200, 100)), mean, deviation);
  }
  EXPECT_GT(deviation[1], 15);
  display_->press(kWindow, "1");
  sender->send_signal(SIGKILL);
  ASSERT_TRUE(sender->wait(kPatience));
  pause(4);
  cv::imwrite(std::string(FOREVIEW_TEST_OUTPUT_DIR) + "/live-window-silent.png", display_->screenshot(kWindow));
  ASSERT_FALSE(viewer->wait(0.01)) << viewer->standard_error();
  display_->press(kWindow, "s");
  pause(1);
  display_->close(kWindow);
  ASSERT_EQ(viewer->wait(kPatience), 0) << viewer->standard_error();
  const json done = summary();
  EXPECT_GT(done["pictures_used"], 0);
  EXPECT_EQ(done["pictures_written"], 1);
  EXPECT_EQ(done["objects_left"], 0) << "OpenGL objects were not given back";
  ASSERT_EQ(done["cameras"].size(), 1U);
  expect_balance(done["cameras"][0]);
  for (const auto& entry : fs::directory_iterator(out_)) EXPECT_EQ(border_of(entry.path()), "silent");
}

}  // namespace
}  // namespace foreview
