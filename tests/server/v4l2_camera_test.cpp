#include "foreview/server/capture/v4l2_camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "foreview/recordings/picture_file.h"
#include "foreview/server/capture/video_modes.h"
#include "server/camera_fixture.h"

namespace foreview {
namespace {

using V4l2CameraTest = SimulatedCameraTest;

TEST_F(V4l2CameraTest, DeliversEveryPictureWithItsStampInWallTime) {
  const std::vector<CapturedPicture> pictures = capture(seconds(10));
  ASSERT_EQ(pictures.size(), 299u + 1);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const CapturedPicture& picture = pictures[i];
    EXPECT_EQ(picture.sequence, i);
    EXPECT_EQ(picture.encoding, "yuv422_yuy2");
    EXPECT_EQ(picture.width, 8);
    EXPECT_EQ(picture.height, 4);
    EXPECT_EQ(picture.stamp_kind, StampKind::start_of_exposure);
    // The n-th picture is there after n + 1 periods, and was stamped `transfer` before.
    const double monotonic = 100 + static_cast<double>(i + 1) / 30 - 0.012;
    EXPECT_NEAR((picture.stamp - Timestamp{1'700'000'000'000'000'000}).seconds(), monotonic, 2e-6);
    ASSERT_EQ(picture.bytes.size(), 64u);
    for (std::size_t y = 0; y < 4; ++y) {
      for (std::size_t x = 0; x < 16; ++x) {
        ASSERT_EQ(picture.bytes[16 * y + x], static_cast<unsigned char>(16 * y + x + i));
      }
    }
  }
  EXPECT_EQ(camera().statistics().delivered, 300u);
  EXPECT_EQ(camera().statistics().lost, 0u);
  EXPECT_EQ(camera().name(), "Simulated camera");
  EXPECT_EQ(camera().mode().to_string(), "YUYV 8x4 at 30 Hz");
}

TEST_F(V4l2CameraTest, EachFormatHasItsEncodingAndRowsWithoutPadding) {
  const struct {
    std::uint32_t fourcc;
    const char* encoding;
    std::size_t row;
  } cases[] = {
      {V4L2_PIX_FMT_YUYV, "yuv422_yuy2", 16}, {V4L2_PIX_FMT_UYVY, "yuv422", 16}, {V4L2_PIX_FMT_GREY, "mono8", 8}};
  for (const auto& expected : cases) {
    close_camera();
    device.modes = {{.fourcc = expected.fourcc}};
    device.padding = 24;
    const std::vector<CapturedPicture> pictures = capture(ms(100));
    ASSERT_FALSE(pictures.empty());
    EXPECT_EQ(pictures[0].encoding, expected.encoding);
    ASSERT_EQ(pictures[0].bytes.size(), 4 * expected.row);
    EXPECT_EQ(pictures[0].bytes[expected.row], 16);  // the second line's first, no padding between
  }
}

TEST_F(V4l2CameraTest, PassesMjpegOnAndTakesDriversThatSayJpeg) {
  for (const std::uint32_t fourcc : {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_JPEG}) {
    close_camera();
    device.modes = {{.fourcc = fourcc, .width = 64, .height = 48}};
    const std::vector<CapturedPicture> pictures = capture(ms(200));
    ASSERT_GE(pictures.size(), 5u);
    EXPECT_EQ(pictures[3].encoding, "jpeg");
    EXPECT_EQ(pictures[3].bytes, device.mjpeg(3));
    EXPECT_EQ(decode_picture(pictures[3].bytes, "picture").size(), cv::Size(64, 48));
  }
}

TEST_F(V4l2CameraTest, StampsFollowWallTimeAsItIsSetAndSlewed) {
  options.stamp_shift = ms(-7);
  for (int i = 1; i < 100; ++i) {
    device.at(ms(100 * i), [&] { device.wall_offset = device.wall_offset + Duration{50'000}; });  // 500 ppm
  }
  device.at(seconds(5), [&] { device.wall_offset = device.wall_offset + seconds(3600); });
  V4l2Camera& source = camera();
  for (int i = 0; i < 290; ++i) {
    const auto picture = source.next(ms(100));
    ASSERT_TRUE(picture);
    const Timestamp truth = device.monotonic() + device.wall_offset - device.transfer - ms(7);
    EXPECT_NEAR((picture->stamp - truth).seconds(), 0, 2e-6) << i;
  }
}

TEST_F(V4l2CameraTest, TellsWhatTheStampIsOf) {
  device.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  EXPECT_EQ(capture(ms(50)).at(0).stamp_kind, StampKind::end_of_frame);
}

TEST_F(V4l2CameraTest, ReturnsAfterTheTimeoutAndOnSignals) {
  device.is_silent = true;
  V4l2Camera& source = camera();
  const Timestamp begin = device.monotonic();
  EXPECT_FALSE(source.next(ms(250)));
  EXPECT_EQ(device.monotonic() - begin, ms(250));
  device.interrupted_polls = 1;
  EXPECT_FALSE(source.next(seconds(1)));
  EXPECT_EQ(device.monotonic() - begin, ms(250));
  EXPECT_FALSE(source.next({}));
}

TEST_F(V4l2CameraTest, ASlowReaderGetsTheNewestAndTheRestIsCounted) {
  V4l2Camera& source = camera();
  for (int i = 0; i < 20; ++i) {
    device.advance(ms(110));  // 3.3 periods
    const auto picture = source.next(ms(100));
    ASSERT_TRUE(picture);
    const Duration age = device.monotonic() + device.wall_offset - picture->stamp;
    EXPECT_LT(age, ms(34 + 12));
  }
  const auto& statistics = source.statistics();
  EXPECT_EQ(statistics.delivered, 20u);
  EXPECT_NEAR(static_cast<double>(statistics.overtaken), 46, 1);
  EXPECT_EQ(statistics.lost, 0u);

  // Slower than the buffers last: the driver drops, and its numbers tell.
  for (int i = 0; i < 10; ++i) {
    device.advance(ms(1000));
    ASSERT_TRUE(source.next(ms(100)));
  }
  // What was dropped after the last picture taken is not known yet.
  EXPECT_NEAR(static_cast<double>(source.statistics().lost), static_cast<double>(device.overruns), 27);
  EXPECT_GT(source.statistics().lost, 200u);
}

TEST_F(V4l2CameraTest, WithoutNewestOnlyEveryPictureComes) {
  options.newest_only = false;
  V4l2Camera& source = camera();
  device.advance(ms(110));
  for (std::uint64_t i = 0; i < 3; ++i) EXPECT_EQ(source.next({}).value().sequence, i);
  EXPECT_FALSE(source.next({}));
}

/// Like a webcam on USB 2.
std::vector<SimulatedCamera::Mode> webcam() {
  return {{V4L2_PIX_FMT_YUYV, 640, 480, {{1, 30}, {1, 15}}},
          {V4L2_PIX_FMT_YUYV, 1280, 720, {{1, 10}}},
          {V4L2_PIX_FMT_YUYV, 1920, 1080, {{1, 5}}},
          {V4L2_PIX_FMT_MJPEG, 640, 480, {{1, 30}, {1, 15}}},
          {V4L2_PIX_FMT_MJPEG, 1920, 1080, {{1, 60}, {1001, 30000}, {1, 15}}},
          {V4L2_PIX_FMT_MJPEG, 3840, 2160, {{1, 30}}},
          {V4L2_PIX_FMT_H264, 3840, 2160, {{1, 30}}}};
}

TEST_F(V4l2CameraTest, ChoosesByWishOrElseTheBest) {
  device.modes = webcam();
  const struct {
    CaptureWish wish;
    const char* mode;
  } cases[] = {
      {{}, "MJPEG 1920x1080 at 60 Hz"},
      {{.rate = 30}, "MJPEG 1920x1080 at 29.97 Hz"},
      {{.rate = 20}, "MJPEG 1920x1080 at 29.97 Hz"},
      {{.format = CaptureFormat::yuyv}, "YUYV 640x480 at 30 Hz"},
      {{.format = CaptureFormat::yuyv, .rate = 10}, "YUYV 1280x720 at 10 Hz"},
      {{.format = CaptureFormat::yuyv, .width = 1920, .height = 1080}, "YUYV 1920x1080 at 5 Hz"},
      {{.width = 640, .height = 480, .rate = 12}, "MJPEG 640x480 at 15 Hz"},
      {{.width = 1280, .height = 720}, "YUYV 1280x720 at 10 Hz"},
      {{.width = 3840, .height = 2160}, "MJPEG 3840x2160 at 30 Hz"},
      {{.rate = 1000}, "MJPEG 1920x1080 at 60 Hz"},
  };
  for (const auto& expected : cases) {
    close_camera();
    options.wish = expected.wish;
    EXPECT_EQ(camera().mode().to_string(), expected.mode);
    EXPECT_NEAR(device.rate(), camera().mode().rate(), 1e-9);
    EXPECT_EQ(device.format().width, static_cast<std::uint32_t>(camera().mode().width));
  }
}

TEST_F(V4l2CameraTest, SaysWhatThereIsWhereAWishCannotBeMet) {
  device.modes = webcam();
  options.wish.format = CaptureFormat::grey;
  EXPECT_EQ(error_of_capture(), "/dev/video0: has no GREY; expected one of MJPEG, YUYV");
  options.wish = {.width = 800, .height = 600};
  EXPECT_EQ(error_of_capture(),
            "/dev/video0: has no pictures of 800x600; expected one of MJPEG 1920x1080, MJPEG 3840x2160, MJPEG 640x480, "
            "YUYV 1280x720, YUYV 1920x1080, YUYV 640x480");
  options.wish = {};
  device.modes = {{.fourcc = V4L2_PIX_FMT_H264}};
  EXPECT_EQ(error_of_capture(), "/dev/video0: has no format that is taken; expected MJPEG, YUYV, UYVY or GREY");
}

TEST_F(V4l2CameraTest, RangesOfSizesAndRatesAreUsed) {
  device.modes = {{V4L2_PIX_FMT_YUYV, 2048, 1536, {}}};
  device.is_stepwise = true;
  options.wish = {.width = 800, .height = 602, .rate = 47};
  EXPECT_EQ(camera().mode().to_string(), "YUYV 800x602 at 47 Hz");
  close_camera();
  options.wish = {.width = 801, .height = 602};
  EXPECT_NE(error_of_capture(ms(1)).find("has no pictures of 801x602"), std::string::npos);
  options.wish = {};
  EXPECT_EQ(camera().mode().to_string(), "YUYV 1920x1080 at 120 Hz");
}

TEST_F(V4l2CameraTest, DriversThatTellNothingAreAskedForTheWishOrTakenAsTheyAre) {
  device.modes = {{V4L2_PIX_FMT_YUYV, 8, 4}};
  device.lists_sizes = device.lists_rates = device.knows_rates = false;
  EXPECT_EQ(camera().mode().to_string(), "YUYV 8x4");
  EXPECT_FALSE(capture(ms(100)).empty());
  close_camera();
  options.wish = {.width = 16, .height = 8};
  EXPECT_EQ(error_of_capture(), "/dev/video0: gives YUYV 8x4 when asked for 16x8; expected YUYV of that size");
}

TEST_F(V4l2CameraTest, ListsCameras) {
  device.modes = webcam();
  const std::vector<VideoDevice> devices = list_video_devices(device);
  ASSERT_EQ(devices.size(), 1u);
  EXPECT_EQ(devices[0].path, "/dev/video0");
  EXPECT_EQ(devices[0].name, "Simulated camera");
  EXPECT_EQ(devices[0].modes.size(), 10u);
  EXPECT_EQ(devices[0].modes[0].to_string(), "YUYV 640x480 at 30 Hz");
}

TEST(CaptureFormat, IsReadByName) {
  EXPECT_EQ(parse_capture_format("mjpeg", "--format"), CaptureFormat::mjpeg);
  EXPECT_EQ(parse_capture_format("Uyvy", "--format"), CaptureFormat::uyvy);
  try {
    static_cast<void>(parse_capture_format("h264", "--format"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "--format: 'h264' is no format of a camera; expected mjpeg, yuyv, uyvy or grey");
  }
}

TEST(RealVideoSystem, WhatIsNoCameraIsRefusedInOneLine) {
  const auto error = [](const char* device) -> std::string {
    try {
      V4l2Camera opened({.device = device});
    } catch (const VideoError& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_EQ(error("/dev/null"), "/dev/null: is no video device; expected one such as /dev/video0");
  EXPECT_EQ(error("/nonexistent/video0"), "/nonexistent/video0: does not exist; expected a camera such as /dev/video0");
  EXPECT_EQ(error("/"), "/: cannot be opened: Is a directory");
}

}  // namespace
}  // namespace foreview
