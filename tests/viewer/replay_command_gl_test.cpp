#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"
#include "viewer/run_foreview.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using test::Finished;
using test::run_foreview;
using test::RunningForeview;
using test::TemporaryDirectory;
using test::WallRecording;

constexpr int kPictures = 16;

/// One recording for all tests of this program.
const fs::path& wall_recording() {
  static const TemporaryDirectory directory;
  static const fs::path path = [] {
    WallRecording::write(directory.path() / "wall", kPictures);
    return directory.path() / "wall";
  }();
  return path;
}

void expect_one_line_error(const Finished& run, int status, const std::string& mentions) {
  EXPECT_EQ(run.status, status) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_EQ(run.err.rfind("foreview: ", 0), 0U) << run.err;
  EXPECT_NE(run.err.find(mentions), std::string::npos) << run.err;
}

std::map<std::string, std::string> files_under(const fs::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    files[fs::relative(entry.path(), directory).string()] = {std::istreambuf_iterator<char>(stream), {}};
  }
  return files;
}

std::vector<cv::Mat> pictures_under(const fs::path& directory) {
  std::vector<cv::Mat> pictures;
  for (const auto& [name, bytes] : files_under(directory)) pictures.push_back(cv::imread((directory / name).string()));
  return pictures;
}

TEST(Executable, WithoutSubcommand) {
  expect_one_line_error(run_foreview({}), 2, "subcommand");
}

TEST(Executable, UnknownSubcommandOrOption) {
  expect_one_line_error(run_foreview({"dance"}), 2, "--help");
  expect_one_line_error(run_foreview({"--dance"}), 2, "--help");
  expect_one_line_error(run_foreview({"replay", "somewhere", "--dance"}), 2, "foreview replay --help");
}

TEST(Executable, Version) {
  const Finished run = run_foreview({"--version"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.out.rfind("foreview ", 0), 0U) << run.out;
}

TEST(Executable, EveryHelpEndsWithAnExample) {
  const Finished help = run_foreview({"--help"});
  ASSERT_EQ(help.status, 0);
  std::vector<std::string> subcommands;
  std::istringstream lines(help.out.substr(std::min(help.out.find("Subcommands:"), help.out.size())));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && line.rfind("  ", 0) == 0) {
    if (line[2] != ' ') subcommands.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  EXPECT_NE(std::find(subcommands.begin(), subcommands.end(), "replay"), subcommands.end()) << help.out;
  for (const std::string& subcommand : subcommands) {
    const Finished run = run_foreview({subcommand, "--help"});
    EXPECT_EQ(run.status, 0) << subcommand;
    const std::size_t example = run.out.rfind("Example");
    ASSERT_NE(example, std::string::npos) << run.out;
    EXPECT_NE(run.out.find("foreview " + subcommand, example), std::string::npos) << run.out;
  }
}

TEST(Replay, WrongArguments) {
  expect_one_line_error(run_foreview({"replay"}), 2, "RECORDING");
  expect_one_line_error(run_foreview({"replay", "no/such/place", "--headless", "--out", "x"}), 2, "no/such/place");
  const std::string wall = wall_recording().string();
  expect_one_line_error(run_foreview({"replay", wall, "--headless"}), 2, "--out");
  expect_one_line_error(run_foreview({"replay", wall, "--view", "sideways"}), 2, "--view");
  expect_one_line_error(run_foreview({"replay", wall, "--speed", "-1"}), 2, "--speed");
  expect_one_line_error(run_foreview({"replay", wall, "--speed", "nan"}), 2, "--speed");
  expect_one_line_error(run_foreview({"replay", wall, "--every", "0"}), 2, "--every");
  expect_one_line_error(run_foreview({"replay", wall, "--delay", "soon"}), 2, "--delay");
  expect_one_line_error(run_foreview({"replay", wall, "--quiet", "--headless", "--out", "x", "--from", "#900"}), 2,
                        "--from");
}

TEST(Replay, WithoutADisplayItNamesTheWayOut) {
  expect_one_line_error(run_foreview({"replay", wall_recording().string()}, {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}}),
                        3, "--headless --out DIR");
}

TEST(Replay, RefusesAnUnknownDebugMode) {
  expect_one_line_error(
      run_foreview({"replay", wall_recording().string(), "--headless", "--out", "x"}, {{"FOREVIEW_GL_DEBUG", "loud"}}),
      2, "FOREVIEW_GL_DEBUG");
}

TEST(Replay, RegistrationIsAutoOrOff) {
  const std::string recording = wall_recording().string();
  for (const char* command : {"replay", "view", "evaluate"}) {
    expect_one_line_error(run_foreview({command, recording, "--registration", "on"}), 2,
                          "--registration: 'on' is none of its values: auto, off");
  }
}

TEST(Replay, OutThatCannotBeWritten) {
  const TemporaryDirectory out;
  out.write("file", "in the way");
  expect_one_line_error(
      run_foreview({"replay", wall_recording().string(), "--quiet", "--headless", "--out", (out / "file").string()}), 2,
      "cannot be written");
}

Finished headless(const fs::path& out, std::vector<std::string> more) {
  std::vector<std::string> arguments{
      "replay", wall_recording().string(), "--headless", "--out", out.string(), "--delay", "120ms", "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_foreview(arguments);
}

TEST(Replay, HeadlessTwiceGivesTheSameBytes) {
  const TemporaryDirectory first, second;
  const std::vector<std::string> more{"--view", "both", "--every", "3", "--wireframe", "--holes", "--edges"};
  const Finished run = headless(first.path(), more);
  ASSERT_EQ(run.status, 0) << run.err;
  ASSERT_EQ(headless(second.path(), more).status, 0);
  const auto a = files_under(first.path()), b = files_under(second.path());
  EXPECT_EQ(a.size(), (kPictures + 2) / 3U);
  EXPECT_EQ(a, b);
}

TEST(Replay, HeadlessShowsTheRightInstants) {
  const TemporaryDirectory out;
  for (const char* view : {"predicted", "delayed", "both"}) {
    const Finished run = headless(out.path(), {"--view", view, "--json", (out / "summary.json").string()});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  const auto predicted = pictures_under(out / "predicted"), delayed = pictures_under(out / "delayed"),
             both = pictures_under(out / "both");
  ASSERT_EQ(predicted.size(), std::size_t{kPictures});
  ASSERT_EQ(delayed.size(), std::size_t{kPictures});
  ASSERT_EQ(both.size(), std::size_t{kPictures});
  for (int i = 0; i < kPictures; ++i) {
    const auto k = static_cast<std::size_t>(i);
    ASSERT_EQ(predicted[k].size(), cv::Size(WallRecording::kWidth, WallRecording::kHeight));
    cv::Mat side_by_side;
    cv::hconcat(predicted[k], delayed[k], side_by_side);
    EXPECT_EQ(cv::norm(side_by_side, both[k], cv::NORM_INF), 0) << i;
    // Only pictures captured strictly before t - 120 ms, the fourth before, may be shown.
    if (i < 4) {
      EXPECT_EQ(cv::norm(delayed[k], cv::NORM_INF), 0) << i;
    } else {
      EXPECT_EQ(cv::norm(delayed[k], WallRecording::truth(i - 4), cv::NORM_INF), 0) << i;
      EXPECT_GT(cv::PSNR(predicted[k], WallRecording::truth(i)), 24) << i;
      EXPECT_GT(cv::PSNR(predicted[k], WallRecording::truth(i)), cv::PSNR(delayed[k], WallRecording::truth(i)) + 6)
          << i;
    }
  }
  std::ifstream stream(out / "summary.json");
  const nlohmann::json summary = nlohmann::json::parse(stream);
  EXPECT_EQ(summary["version"], 1);
  EXPECT_EQ(summary["pictures_written"], kPictures);
  EXPECT_EQ(summary["pictures_extracted"], kPictures - 4);
}

TEST(Replay, HeadlessFromToAndHistory) {
  const TemporaryDirectory out;
  const Finished run = headless(out.path(), {"--from", "#6", "--to", "0.4", "--history", "2"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(files_under(out / "predicted").size(), 5U);  // #6 to #10
}

TEST(Replay, HeadlessAtOneMomentFromAnywhere) {
  const TemporaryDirectory out;
  const auto frame = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--at", "0.4"});
    const Finished run = headless(out.path(), std::move(more));
    EXPECT_EQ(run.status, 0) << run.err;
    return cv::imread((out / "predicted" / "at-0.400s.png").string());
  };
  const cv::Mat plain = frame({});
  ASSERT_FALSE(plain.empty());
  EXPECT_GT(cv::PSNR(plain, WallRecording::truth(10)), 24);
  // From where picture 10 was taken; from elsewhere; with another angle.
  EXPECT_LT(cv::norm(frame({"--camera-mode", "free", "--camera-pose=-0.1 0.1 0 0 0 0 1"}), plain, cv::NORM_INF), 4);
  EXPECT_GT(cv::norm(frame({"--camera-mode", "free", "--camera-pose=-0.3 0.1 0 0 0 0 1"}), plain, cv::NORM_INF), 40);
  EXPECT_GT(cv::norm(frame({"--fov", "20"}), plain, cv::NORM_INF), 40);
  EXPECT_GT(cv::norm(frame({"--camera-mode", "overview", "--cone"}), plain, cv::NORM_INF), 40);
  EXPECT_EQ(files_under(out.path()).size(), 1U);
  expect_one_line_error(headless(out.path(), {"--at", "99"}), 2, "--at");
  expect_one_line_error(run_foreview({"replay", wall_recording().string(), "--at", "0.4"}), 2, "--at");
}

TEST(Replay, TexturesAreKeptBetweenRuns) {
  const TemporaryDirectory out;
  const std::string textures = (out / "textures").string();
  ASSERT_EQ(headless(out / "a", {"--save-textures", textures}).status, 0);
  // At the first picture none is old enough: all that is seen comes from the file.
  const Finished run = headless(out / "b", {"--load-textures", textures, "--to", "#0"});
  ASSERT_EQ(run.status, 0) << run.err;
  const auto predicted = pictures_under(out / "b");
  ASSERT_EQ(predicted.size(), 1U);
  EXPECT_GT(cv::PSNR(predicted[0], WallRecording::truth(0)), 24);
}

TEST(Replay, CtrlCLeavesWholeFiles) {
  const TemporaryDirectory out;
  RunningForeview running({"replay", wall_recording().string(), "--headless", "--out", out.path().string(), "--quiet"});
  for (int i = 0; i < 1000 && files_under(out.path()).empty(); ++i) {
    ASSERT_FALSE(running.wait(0.01)) << running.standard_error();
  }
  running.send_signal(SIGINT);
  const auto status = running.wait(60);
  EXPECT_TRUE(status == 130 || status == 0) << status.value_or(-1);
  if (status == 130) {
    EXPECT_EQ(running.standard_error(), "foreview: interrupted\n");
  }
  for (const auto& [name, bytes] : files_under(out.path())) {
    EXPECT_EQ(fs::path(name).extension(), ".png");
    EXPECT_FALSE(cv::imread((out / name).string()).empty()) << name;
  }
}

}  // namespace
}  // namespace foreview
