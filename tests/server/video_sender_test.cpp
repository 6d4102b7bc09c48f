#include "foreview/server/video_sender.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "child_process.h"
#include "dds_test_domain.h"
#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"
#include "played_recording.h"
#include "simulated_camera.h"

namespace foreview {
namespace {

constexpr int kWidth = 32, kHeight = 16;

struct Format {
  const char* name;
  std::uint32_t fourcc;
  CaptureFormat format;
  const char* topic;
};

/// Picture `number` as the simulated device makes it, turned into BGR here.
cv::Mat expected_picture(const Format& format, int number) {
  if (format.format == CaptureFormat::mjpeg) {
    cv::Mat picture(kHeight, kWidth, CV_8UC3);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        picture.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<unsigned char>(5 * x), static_cast<unsigned char>(7 * y),
                                                static_cast<unsigned char>(10 * number));
      }
    }
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", picture, bytes);
    return cv::imdecode(bytes, cv::IMREAD_COLOR);
  }
  const bool is_grey = format.format == CaptureFormat::grey;
  cv::Mat raw(kHeight, kWidth, is_grey ? CV_8UC1 : CV_8UC2);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth * (is_grey ? 1 : 2); ++x) {
      raw.ptr(y)[x] = static_cast<unsigned char>(16 * y + x + number);
    }
  }
  cv::Mat picture;
  cv::cvtColor(raw, picture,
               is_grey                                ? cv::COLOR_GRAY2BGR
               : format.format == CaptureFormat::yuyv ? cv::COLOR_YUV2BGR_YUY2
                                                      : cv::COLOR_YUV2BGR_UYVY);
  return picture;
}

class VideoSenderTest : public testing::TestWithParam<Format> {};

// From the device's buffers to what a display takes: two processes, with DDS between them.
TEST_P(VideoSenderTest, PicturesAndStampsOfADeviceReachTheDisplay) {
  const Format format = GetParam();
  const int domain = test::dds_domain() + 20;
  CameraModel model;
  model.width = kWidth;
  model.height = kHeight;
  model.focal_length = {40, 41};
  model.principal_point = {16.5, 7.5};
  const Pose world_from_camera{glm::normalize(glm::dquat(0.5, 0.1, -0.7, 0.2)), {1, -2, 3}};
  test::Child robot([&] {
    SimulatedCamera device;
    device.modes = {{format.fourcc, kWidth, kHeight}};
    device.padding = format.format == CaptureFormat::mjpeg ? 0 : 24;
    V4l2Camera camera({.wish = {.format = format.format, .width = kWidth, .height = kHeight}}, device);
    DdsNode node({domain});
    VideoSender sender(node, {.name = "eye", .camera = model, .world_from_camera = world_from_camera});
    while (true) {
      if (auto picture = camera.next(Duration{1'000'000'000})) sender.send(std::move(*picture));
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  DdsNode node({domain});
  LiveSource::Options options;
  options.cameras = {{"eye", "", false}};
  LiveSource source(options);
  const LiveReceiver receiver(node, {camera_topics(format.topic)}, source);
  std::set<int> numbers;
  ASSERT_TRUE(test::comes_true([&] {
    const auto frame = source.take();
    if (!frame) return false;
    // The n-th picture is there after n + 1 periods, and was stamped 12 ms before; the device began at 100 s.
    const double since = (frame->frame.state.stamp - Timestamp{1'700'000'100'000'000'000}).seconds() + 0.012;
    const int number = static_cast<int>(std::lround(since * 30)) - 1;
    EXPECT_NEAR(since, (number + 1) / 30.0, 2e-6);
    EXPECT_TRUE(numbers.insert(number).second) << "twice";
    EXPECT_EQ(cv::norm(frame->frame.picture, expected_picture(format, number), cv::NORM_INF), 0) << number;
    EXPECT_EQ(frame->frame.state.world_from_camera, world_from_camera);
    EXPECT_EQ(frame->frame.camera.focal_length, model.focal_length);
    EXPECT_EQ(frame->frame.camera.principal_point, model.principal_point);
    return numbers.size() >= 40 || HasFailure();
  }));
  const SourceStatus status = source.status();
  EXPECT_EQ(status.damaged + status.duplicated, 0U);
  std::printf("%s: pictures %d to %d, %zu of them used\n", format.name, *numbers.begin(), *numbers.rbegin(),
              numbers.size());
}

INSTANTIATE_TEST_SUITE_P(Formats, VideoSenderTest,
                         testing::Values(Format{"mjpeg", V4L2_PIX_FMT_MJPEG, CaptureFormat::mjpeg,
                                                "/eye/image_raw/compressed"},
                                         Format{"yuyv", V4L2_PIX_FMT_YUYV, CaptureFormat::yuyv, "/eye/image_raw"},
                                         Format{"uyvy", V4L2_PIX_FMT_UYVY, CaptureFormat::uyvy, "/eye/image_raw"},
                                         Format{"grey", V4L2_PIX_FMT_GREY, CaptureFormat::grey, "/eye/image_raw"}),
                         [](const auto& information) { return information.param.name; });

}  // namespace
}  // namespace foreview
