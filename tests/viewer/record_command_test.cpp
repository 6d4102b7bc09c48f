#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "foreview/recordings/recording.h"
#include "run_foreview.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

/// A file system of its own, of so many bytes, in memory. Only root may have one.
class SmallDisk {
 public:
  explicit SmallDisk(const std::filesystem::path& at, const std::string& size) : at_(at) {
    std::filesystem::create_directories(at);
    is_there_ = mount("foreview-test", at.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (is_there_) umount2(at_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  [[nodiscard]] bool is_there() const { return is_there_; }

 private:
  std::filesystem::path at_;
  bool is_there_ = false;
};

TEST(RecordCommand, FullDiskEndsItWithStatus2AndWhatWasWrittenIsARecording) {
  const test::TemporaryDirectory directory;
  const SmallDisk disk(directory / "small", "256k");
  if (!disk.is_there()) GTEST_SKIP() << "no file system can be mounted here";
  // A stream of pictures that compress badly.
  RecordingWriter::Description description;
  description.name = "sent";
  CameraModel camera;
  camera.width = 96;
  camera.height = 64;
  camera.focal_length = {80, 80};
  camera.principal_point = {48, 32};
  description.cameras = {{"", camera}};
  constexpr int kPictures = 60;
  {
    RecordingWriter writer(directory / "sent", description);
    cv::Mat noise(64, 96, CV_8UC3);
    cv::RNG random(5);
    for (int i = 0; i < kPictures; ++i) {
      random.fill(noise, cv::RNG::UNIFORM, 0, 256);
      const Timestamp stamp{1'000'000'000 + i * 40'000'000LL};
      writer.add_camera_pose(0, stamp, Pose());
      writer.add_picture(0, stamp, noise, "png");
    }
  }
  const std::string domain = std::to_string(120 + getpid() % 100);
  test::RunningForeview recorder({"record", (directory / "small/out").string(), "--topic",
                                  "/camera/image_raw/compressed", "--domain", domain, "--duration", "40s"});
  test::RunningForeview sender({"send", (directory / "sent").string(), "--wait", "--domain", domain});
  EXPECT_EQ(recorder.wait(60), 2) << recorder.standard_error();
  const std::string told = recorder.standard_error();
  EXPECT_NE(told.find("No space left on device"), std::string::npos) << told;
  // One line, after what it told while it ran.
  ASSERT_NE(told.find("recording ended"), std::string::npos) << told;
  const std::string last = told.substr(told.find("recording ended"));
  EXPECT_EQ(std::count(last.begin(), last.end(), '\n'), 1) << told;
  const Recording recording = Recording::open(directory / "small/out");
  EXPECT_EQ(recording.damage().total(), 0U);
  const std::size_t pictures = recording.cameras()[0].pictures.size();
  EXPECT_GE(pictures, 3U);
  EXPECT_LT(pictures, static_cast<std::size_t>(kPictures));
  for (std::size_t i = 0; i < pictures; ++i) EXPECT_FALSE(recording.read_picture(0, i).empty());
  RecordProperty("pictures", static_cast<int>(pictures));
}

}  // namespace
}  // namespace foreview
