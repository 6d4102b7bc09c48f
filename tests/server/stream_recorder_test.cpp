#include "foreview/server/stream_recorder.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "foreview/server/camera_info.h"
#include "played_recording.h"
#include "support/simulated_disk.h"

namespace foreview {
namespace {

using test::comes_true;
using test::SimulatedDisk;

/// A recorder on a simulated disk, and a robot whose messages go straight into it.
struct RecordedRobot {
  explicit RecordedRobot(SimulatedDisk& disk) {
    StreamRecorder::Options options;
    options.directory = "/nowhere/disk/recording";
    options.name = "recording";
    options.cameras = {{"eye", ""}};
    options.disk = &disk;
    recorder.emplace(options);
    CameraModel camera;
    camera.width = 32;
    camera.height = 24;
    camera.focal_length = {30, 30};
    camera.principal_point = {16, 12};
    recorder->on_camera_info(0, info_from_camera(camera));
  }
  static Timestamp stamp(int i) { return {1'000'000'000'000 + i * 100'000'000LL}; }
  void send(int i, bool is_whole = true, std::uint64_t publisher = 1) {
    const double x = publisher == 1 ? i : -i;
    recorder->on_transforms({{{{stamp(i), "world"}, "optical", Pose{{1, 0, 0, 0}, {x, 0, 0}}}}}, false);
    CompressedImageMessage message{{stamp(i), "optical"}, "jpeg", {}};
    cv::imencode(".png", cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(i)), message.data);
    if (!is_whole) message.data.resize(message.data.size() / 2);
    recorder->on_picture(0, std::move(message), {steady_now(), steady_now(), publisher});
  }
  std::optional<StreamRecorder> recorder;
};

std::size_t readable(const SimulatedDisk& disk, SimulatedDisk::Luck luck, unsigned seed = 0) {
  const test::TemporaryDirectory directory;
  disk.write_remainder(disk.calls(), luck, seed, "/nowhere/disk", directory.path());
  try {
    const Recording recording = Recording::open(directory / "recording");
    EXPECT_EQ(recording.damage().total(), 0U);
    const auto& camera = recording.cameras()[0];
    for (std::size_t k = 0; k < camera.pictures.size(); ++k) {
      const int i = static_cast<int>((camera.pictures[k].stamp - RecordedRobot::stamp(0)).nanoseconds / 100'000'000);
      EXPECT_EQ(recording.read_picture(0, k).at<cv::Vec3b>(0, 0)[0], i);
      EXPECT_EQ(camera.world_from_camera.at(camera.pictures[k].stamp)->translation.x, i);
    }
    return camera.pictures.size();
  } catch (const InputError&) {
    return 0;
  }
}

void expect_sums(const StreamRecorder::Status& status) {
  EXPECT_EQ(status.pictures_in,
            status.written + status.damaged + status.stateless + status.late + status.overflowed + status.unwritten);
}

TEST(StreamRecorder, WhatIsCountedAsWrittenOutlivesAPowerCut) {
  SimulatedDisk disk;
  RecordedRobot robot(disk);
  for (int i = 0; i < 40; ++i) {
    robot.send(i, i % 10 != 3);
    if (i % 3 != 0) continue;
    // At any moment, while it writes.
    const std::size_t written = robot.recorder->status().written;
    EXPECT_GE(readable(disk, SimulatedDisk::Luck::nothing_stays), written);
    EXPECT_GE(readable(disk, SimulatedDisk::Luck::names_stay), written);
  }
  robot.recorder->finish();
  const StreamRecorder::Status status = robot.recorder->status();
  EXPECT_EQ(status.written, 36U);
  EXPECT_EQ(status.damaged, 4U);
  EXPECT_EQ(status.error, "");
  expect_sums(status);
  EXPECT_EQ(readable(disk, SimulatedDisk::Luck::nothing_stays), 36U);
}

TEST(StreamRecorder, FullDiskEndsItWithOneLineAndASoundRecording) {
  for (const std::size_t full : {0, 3, 8, 15, 30, 31, 32, 33, 34, 35, 36, 37, 60, 90}) {
    SCOPED_TRACE(full);
    SimulatedDisk disk;
    disk.full_from = full;
    RecordedRobot robot(disk);
    for (int i = 0; i < 30; ++i) {
      robot.send(i);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(comes_true([&] { return !robot.recorder->status().error.empty(); }));
    for (int i = 30; i < 35; ++i) robot.send(i);
    robot.recorder->finish();
    const StreamRecorder::Status status = robot.recorder->status();
    EXPECT_NE(status.error.find("No space left on device"), std::string::npos) << status.error;
    EXPECT_EQ(status.error.find('\n'), std::string::npos);
    EXPECT_EQ(status.pictures_in, 35U);
    expect_sums(status);
    EXPECT_GE(readable(disk, SimulatedDisk::Luck::nothing_stays), status.written);
    EXPECT_GE(readable(disk, SimulatedDisk::Luck::all_stays), status.written);
  }
}

TEST(StreamRecorder, EndsWhereTheSenderBeginsAnewAndMixesNoPoses) {
  SimulatedDisk disk;
  RecordedRobot robot(disk);
  for (int i = 0; i < 30; ++i) {
    robot.send(i);
    robot.send(i);  // twice
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  int i = 10;
  // Its stamps are those of the first one, its poses are not (readable() compares them).
  for (; i < 200 && robot.recorder->status().error.empty(); ++i) {
    robot.send(i % 30, true, 2);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const StreamRecorder::Status status = robot.recorder->status();
  EXPECT_NE(status.error.find("began anew"), std::string::npos) << status.error;
  EXPECT_LT(i, 60);
  EXPECT_EQ(status.written, 30U);
  EXPECT_GE(status.late, 50U);
  robot.recorder->finish();
  expect_sums(robot.recorder->status());
  EXPECT_EQ(readable(disk, SimulatedDisk::Luck::nothing_stays), 30U);
}

TEST(StreamRecorder, PicturesThatWaitWhereItNeverBeginsAreCounted) {
  SimulatedDisk disk;
  StreamRecorder::Options options;
  options.directory = "/nowhere/disk/recording";
  options.cameras = {{"eye", ""}};
  options.disk = &disk;
  StreamRecorder recorder(options);
  std::vector<std::uint8_t> picture;
  cv::imencode(".png", cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(1)), picture);
  recorder.on_picture(0, CompressedImageMessage{{{1}, "optical"}, "jpeg", picture}, {});
  EXPECT_EQ(recorder.status().waiting_for, "camera_info of eye");
  recorder.finish();
  EXPECT_EQ(recorder.status().unwritten, 1U);
  expect_sums(recorder.status());
  EXPECT_EQ(disk.calls(), 0U);
}

}  // namespace
}  // namespace foreview
