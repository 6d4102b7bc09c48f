// What cameras, cables and drivers do wrong: each fault in figures.
#include <gtest/gtest.h>

#include <cerrno>
#include <random>

#include "server/camera_fixture.h"

namespace foreview {
namespace {

class V4l2FaultsTest : public SimulatedCameraTest {
 protected:
  using Frame = SimulatedCamera::Frame;

  /// Every tenth frame is changed, beginning with the tenth.
  void spoil_every_tenth(std::function<void(Frame&)> spoil) {
    device.make_frame = [spoil = std::move(spoil)](SimulatedCamera& camera, std::uint32_t number) {
      Frame frame = SimulatedCamera::good_frame(camera, number);
      if (number % 10 == 9) spoil(frame);
      return frame;
    };
  }
  /// 10 s at 30 Hz: 270 good pictures, 30 of them counted in `count`, nothing else wrong.
  void expect_tenth_dropped(std::size_t V4l2Camera::Statistics::*count) {
    const std::vector<CapturedPicture> pictures = capture(seconds(10));
    EXPECT_EQ(pictures.size(), 270u);
    for (const CapturedPicture& picture : pictures) EXPECT_NE(picture.sequence % 10, 9u);
    const V4l2Camera::Statistics& statistics = camera().statistics();
    EXPECT_EQ(statistics.*count, 30u);
    EXPECT_EQ(statistics.delivered, 270u);
    EXPECT_EQ(statistics.lost + statistics.restarts + statistics.io_errors, 0u);
  }
};

TEST_F(V4l2FaultsTest, ShortFramesAreDropped) {
  spoil_every_tenth([](Frame& frame) { frame.bytes.pop_back(); });
  expect_tenth_dropped(&V4l2Camera::Statistics::short_frames);
}

TEST_F(V4l2FaultsTest, EmptyFramesAreDropped) {
  spoil_every_tenth([](Frame& frame) { frame.bytes_used = 0; });
  expect_tenth_dropped(&V4l2Camera::Statistics::short_frames);
}

TEST_F(V4l2FaultsTest, ShortJpegsAreDropped) {
  device.modes = {{V4L2_PIX_FMT_MJPEG, 64, 48}};
  spoil_every_tenth([](Frame& frame) { frame.bytes.resize(frame.bytes.size() / 2); });
  expect_tenth_dropped(&V4l2Camera::Statistics::short_frames);
}

TEST_F(V4l2FaultsTest, FramesThatAreTooLongAreDropped) {
  spoil_every_tenth([](Frame& frame) { frame.bytes_used = 65; });
  expect_tenth_dropped(&V4l2Camera::Statistics::wrong_size);
}

TEST_F(V4l2FaultsTest, ADriverThatClaimsMoreThanItsBufferHoldsIsNotBelieved) {
  spoil_every_tenth([](Frame& frame) { frame.bytes_used = 0xffffffff; });
  expect_tenth_dropped(&V4l2Camera::Statistics::wrong_size);
}

TEST_F(V4l2FaultsTest, NothingIsReadBeyondTheBufferInSearchOfAJpegsEnd) {
  device.modes = {{V4L2_PIX_FMT_MJPEG, 64, 48}};
  spoil_every_tenth([](Frame& frame) {
    frame.bytes.resize(frame.bytes.size() / 2);
    frame.bytes_used = 0xffffffff;
  });
  expect_tenth_dropped(&V4l2Camera::Statistics::short_frames);
}

TEST_F(V4l2FaultsTest, JpegsOfAnotherSizeAreDropped) {
  device.modes = {{V4L2_PIX_FMT_MJPEG, 64, 48}};
  spoil_every_tenth([](Frame& frame) {
    // The frame header's height: 48 becomes 47.
    for (std::size_t i = 0; i + 9 < frame.bytes.size(); ++i) {
      if (frame.bytes[i] == 0xff && frame.bytes[i + 1] == 0xc0) {
        frame.bytes[i + 6] = 47;
        return;
      }
    }
  });
  expect_tenth_dropped(&V4l2Camera::Statistics::wrong_size);
}

TEST_F(V4l2FaultsTest, DamagedJpegsAreDropped) {
  device.modes = {{V4L2_PIX_FMT_MJPEG, 64, 48}};
  spoil_every_tenth([](Frame& frame) { frame.bytes[0] = 0; });
  expect_tenth_dropped(&V4l2Camera::Statistics::damaged);
}

TEST_F(V4l2FaultsTest, FramesThatTheDriverCallsDamagedAreDropped) {
  spoil_every_tenth([](Frame& frame) { frame.flags = V4L2_BUF_FLAG_ERROR; });
  expect_tenth_dropped(&V4l2Camera::Statistics::flagged);
}

TEST_F(V4l2FaultsTest, ImpossibleStampsAreDropped) {
  const Timestamp begin = device.monotonic();
  for (const std::int64_t stamp_us :
       {std::int64_t{0}, std::int64_t{-5}, (begin.nanoseconds + seconds(60).nanoseconds) / 1000,
        (begin.nanoseconds - seconds(11).nanoseconds) / 1000, INT64_MAX / 2}) {
    close_camera();
    device.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    spoil_every_tenth([=](Frame& frame) { frame.stamp_us = stamp_us; });
    expect_tenth_dropped(&V4l2Camera::Statistics::bad_stamps);
  }
}

TEST_F(V4l2FaultsTest, AnOldStampIsDroppedEvenIfItIsTheFirst) {
  device.make_frame = [](SimulatedCamera& camera, std::uint32_t number) {
    Frame frame = SimulatedCamera::good_frame(camera, number);
    if (number < 2) frame.stamp_us = (camera.monotonic() - (number == 0 ? seconds(11) : seconds(9))).nanoseconds / 1000;
    return frame;
  };
  EXPECT_EQ(capture(seconds(1)).at(0).sequence, 1u);
  EXPECT_EQ(camera().statistics().bad_stamps, 1u);
}

TEST_F(V4l2FaultsTest, StampsThatStandStillAreDropped) {
  std::int64_t last = 0;
  device.make_frame = [&](SimulatedCamera& camera, std::uint32_t number) {
    Frame frame = SimulatedCamera::good_frame(camera, number);
    if (number % 10 != 9) last = (device.monotonic() - device.transfer).nanoseconds / 1000;
    frame.stamp_us = last;
    return frame;
  };
  expect_tenth_dropped(&V4l2Camera::Statistics::bad_stamps);
}

TEST_F(V4l2FaultsTest, MissingStampsAreAnErrorUnlessArrivalWillDo) {
  device.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  EXPECT_EQ(error_of_capture(),
            "/dev/video0: does not stamp its pictures; expected stamps of the monotonic clock, or to be told to take "
            "the time of arrival");
  close_camera();
  options.stamp_on_arrival = true;
  V4l2Camera& source = camera();
  for (int i = 0; i < 30; ++i) {
    const auto picture = source.next(seconds(1));
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->stamp_kind, StampKind::arrival);
    EXPECT_EQ(picture->stamp, device.monotonic() + device.wall_offset);
  }
}

TEST_F(V4l2FaultsTest, GapsInTheDriversNumbersAreLost) {
  device.make_frame = [](SimulatedCamera& camera, std::uint32_t number) {
    Frame frame = SimulatedCamera::good_frame(camera, number);
    frame.sequence = 0xfffffff0 + number + 2 * (number / 10);  // 2 lost after each ten, across the end of 32 bits
    return frame;
  };
  const std::vector<CapturedPicture> pictures = capture(seconds(10));
  EXPECT_EQ(pictures.size(), 300u);
  EXPECT_EQ(camera().statistics().lost, 58u);
  EXPECT_EQ(pictures.back().sequence, 357u);
}

TEST_F(V4l2FaultsTest, DriversThatDoNotCountLoseNothing) {
  device.make_frame = [](SimulatedCamera& camera, std::uint32_t number) {
    Frame frame = SimulatedCamera::good_frame(camera, number);
    frame.sequence = 0;
    return frame;
  };
  const std::vector<CapturedPicture> pictures = capture(seconds(1));
  EXPECT_EQ(camera().statistics().lost, 0u);
  EXPECT_EQ(pictures.back().sequence, pictures.size() - 1);
}

TEST_F(V4l2FaultsTest, SingleInputOutputErrorsPass) {
  device.failing[VIDIOC_DQBUF] = {0, 0, 0, -EIO, 0, 0, -EIO, -EIO};
  EXPECT_EQ(capture(seconds(1)).size(), 30u);
  EXPECT_EQ(camera().statistics().io_errors, 3u);
  EXPECT_EQ(camera().statistics().restarts, 0u);
}

TEST_F(V4l2FaultsTest, BuffersThatAnErrorSwallowsComeBack) {
  // Each error costs a buffer that neither side holds then; without recovery the fourth would be the last.
  device.failed_dequeue_takes_buffer = true;
  for (int i = 0; i < 20; ++i) {
    for (const int error : {0, 0, -EIO}) device.failing[VIDIOC_DQBUF].push_back(error);
  }
  const std::vector<CapturedPicture> pictures = capture(seconds(4));
  const auto& statistics = camera().statistics();
  EXPECT_EQ(statistics.io_errors, 20u);
  EXPECT_EQ(statistics.buffers_recovered, device.discarded);
  EXPECT_GT(device.discarded, 5u);
  EXPECT_EQ(statistics.restarts, 0u);
  EXPECT_EQ(pictures.size() + statistics.overtaken + device.discarded, 120u);
  EXPECT_EQ(statistics.lost, device.discarded);
}

TEST_F(V4l2FaultsTest, LastingErrorsBeginTheStreamAnewAndThenEndIt) {
  for (int i = 0; i < 15; ++i) device.failing[VIDIOC_DQBUF].push_back(-EIO);
  EXPECT_GE(capture(seconds(1)).size(), 28u);
  EXPECT_EQ(camera().statistics().restarts, 1u);
  EXPECT_EQ(device.opened, 2u);

  device.failing[VIDIOC_DQBUF].assign(1000, -EIO);
  EXPECT_EQ(error_of_capture(), "/dev/video0: cannot be read: Input/output error, again and again; expected pictures");
  EXPECT_EQ(camera().statistics().restarts, 1u + 4);
  EXPECT_EQ(device.open_files, 0u);
}

TEST_F(V4l2FaultsTest, LastingErrorsAreWaitedOutWhereAskedTo) {
  options.reopen = true;
  camera();
  device.failing[VIDIOC_DQBUF].assign(80, -EIO);
  const std::vector<CapturedPicture> pictures = capture(seconds(20));
  const auto& statistics = camera().statistics();
  EXPECT_EQ(statistics.io_errors, 80u);
  EXPECT_EQ(statistics.restarts, 8u);  // after the third, once a second
  EXPECT_GE(pictures.size(), 14u * 30);
}

TEST_F(V4l2FaultsTest, PollErrorsDoNotSpin) {
  // A driver that reports an error for ever without saying which.
  options.reopen = true;
  options.reopen_every = seconds(1);
  camera();
  device.failing[VIDIOC_DQBUF].assign(100000, -EAGAIN);
  capture(seconds(10));
  EXPECT_LT(camera().statistics().io_errors, 150u);
}

TEST_F(V4l2FaultsTest, UnpluggingIsOneLine) {
  device.at(ms(500), [&] { device.unplug(); });
  EXPECT_EQ(error_of_capture(), "/dev/video0: is gone: unplugged, or reset; expected a camera that stays");
  EXPECT_EQ(camera().statistics().unplugged, 1u);
  EXPECT_FALSE(camera().statistics().is_open);
  EXPECT_EQ(device.mappings, 0u);
}

TEST_F(V4l2FaultsTest, AnUnpluggedCameraIsReopenedWhenItComesBack) {
  options.reopen = true;
  for (int i = 0; i < 5; ++i) {
    device.at(seconds(10 * i) + ms(505), [&] { device.unplug(); });
    // Back, but not yet with the right to open it, and then held by who looks at new devices.
    device.at(seconds(10 * i + 3), [&] {
      device.plug_in();
      device.open_error = -EACCES;
    });
    device.at(seconds(10 * i + 4) + ms(100), [&] {
      device.open_error = 0;
      device.is_held_by_another = true;
    });
    device.at(seconds(10 * i + 5) + ms(100), [&] { device.is_held_by_another = false; });
  }
  const std::vector<CapturedPicture> pictures = capture(seconds(50));
  const auto& statistics = camera().statistics();
  EXPECT_EQ(statistics.unplugged, 5u);
  EXPECT_EQ(statistics.reopened, 5u);
  EXPECT_EQ(statistics.restarts, 0u);
  // Away for 3 s, refused for 2.1 s more, asked once a second: 5 to 6 s of each 10 s without pictures.
  EXPECT_NEAR(static_cast<double>(pictures.size()), 5 * 4.5 * 30, 5 * 0.6 * 30);
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    EXPECT_GT(pictures[i].sequence, pictures[i - 1].sequence);
    EXPECT_GT(pictures[i].stamp, pictures[i - 1].stamp);
  }
}

TEST_F(V4l2FaultsTest, NextReturnsInTimeWhileTheCameraIsAway) {
  options.reopen = true;
  V4l2Camera& source = camera();
  device.unplug();
  for (int i = 0; i < 50; ++i) {
    const Timestamp begin = device.monotonic();
    EXPECT_FALSE(source.next(ms(100)));
    EXPECT_EQ(device.monotonic() - begin, ms(100));
  }
  const Timestamp begin = device.monotonic();
  device.interrupted_polls = 1;
  EXPECT_FALSE(source.next(ms(100)));
  EXPECT_EQ(device.monotonic(), begin);
}

TEST_F(V4l2FaultsTest, AnotherCameraInItsPlaceIsRefused) {
  options.reopen = true;
  device.at(ms(500), [&] { device.unplug(); });
  device.at(seconds(1), [&] {
    device.modes = {{V4L2_PIX_FMT_YUYV, 16, 8}};
    device.plug_in();
  });
  EXPECT_EQ(error_of_capture(seconds(5)), "/dev/video0: came back with YUYV 16x8 at 30 Hz; expected YUYV 8x4 at 30 Hz");
}

TEST_F(V4l2FaultsTest, AStalledStreamIsBegunAnew) {
  device.at(seconds(2), [&] { device.is_silent = true; });
  device.at(seconds(8), [&] { device.is_silent = false; });
  const std::vector<CapturedPicture> pictures = capture(seconds(12));
  EXPECT_EQ(camera().statistics().stalls, 1u);
  EXPECT_EQ(camera().statistics().restarts, 1u);
  EXPECT_NEAR(static_cast<double>(pictures.size()), 6 * 30, 2);
}

TEST_F(V4l2FaultsTest, ATriggeredCameraMayBeSilent) {
  options.stall = {};
  device.is_silent = true;
  device.at(seconds(600), [&] { device.is_silent = false; });
  EXPECT_NEAR(static_cast<double>(capture(seconds(601)).size()), 30, 1);
  EXPECT_EQ(camera().statistics().restarts, 0u);
}

TEST_F(V4l2FaultsTest, ABusyCameraIsOneLine) {
  device.is_held_by_another = true;
  const std::string busy = "/dev/video0: is in use by another program; expected a free camera";
  EXPECT_EQ(error_of_capture(), busy);
  device.is_held_by_another = false;
  device.open_error = -EBUSY;
  EXPECT_EQ(error_of_capture(), busy);
  device.open_error = 0;
  device.failing[VIDIOC_STREAMON] = {-EBUSY};
  EXPECT_EQ(error_of_capture(), busy);
}

TEST_F(V4l2FaultsTest, FewerBuffersWillDoAndTooFewAreOneLine) {
  device.most_buffers = 2;
  EXPECT_EQ(capture(seconds(1)).size(), 30u);
  close_camera();
  device.most_buffers = 1;
  EXPECT_EQ(error_of_capture(),
            "/dev/video0: gives 1 of 4 buffers; expected 2 or more, one to fill while the other is read");
  device.failing[VIDIOC_REQBUFS] = {-ENOMEM};
  EXPECT_EQ(error_of_capture(),
            "/dev/video0: gives no buffers: no memory for its buffers; expected room for YUYV 8x4 at 30 Hz");
}

TEST_F(V4l2FaultsTest, ARefusedBufferDoesNotStopTheStream) {
  device.failing[VIDIOC_QBUF] = {0, 0, 0, 0, 0, 0, -EINVAL, 0, 0, -ENOMEM};
  EXPECT_EQ(capture(seconds(1)).size(), 30u);
  EXPECT_EQ(camera().statistics().buffers_recovered + camera().statistics().restarts, 2u);
}

TEST_F(V4l2FaultsTest, WhateverCallFailsWhileOpeningIsOneLineAndLeavesNothing) {
  const unsigned long calls[] = {VIDIOC_QUERYCAP, VIDIOC_G_FMT, VIDIOC_S_FMT,   VIDIOC_REQBUFS,
                                 VIDIOC_QUERYBUF, VIDIOC_QBUF,  VIDIOC_STREAMON};
  for (const unsigned long call : calls) {
    for (const int error : {-EINVAL, -EIO, -ENODEV, -ENOMEM, -EBUSY, -ENOSPC}) {
      for (std::size_t before = 0; before < (call == VIDIOC_QUERYBUF || call == VIDIOC_QBUF ? 4 : 1); ++before) {
        device.failing.clear();
        device.failing[call].assign(before, 0);
        device.failing[call].push_back(error);
        EXPECT_NE(error_of_capture(ms(1)), "") << call << " " << error;
        close_camera();
        EXPECT_EQ(device.open_files, 0u);
        EXPECT_EQ(device.mappings, 0u);
      }
    }
  }
}

TEST_F(V4l2FaultsTest, DriversThatAnswerNonsenseAreOneLine) {
  const std::function<void(v4l2_pix_format&)> nonsense[] = {
      [](v4l2_pix_format& f) { f.bytesperline = 3; },
      [](v4l2_pix_format& f) { f.width = f.height = 0; },
      [](v4l2_pix_format& f) { f.width = 0x7fffffff; },
      [](v4l2_pix_format& f) { f.sizeimage = 0xffffffff; },
      [](v4l2_pix_format& f) { f.pixelformat = V4L2_PIX_FMT_H264; },
      [](v4l2_pix_format& f) { f.field = V4L2_FIELD_ALTERNATE; },
  };
  for (const auto& answer : nonsense) {
    device.adjust_format = [&](v4l2_format& format) { answer(format.fmt.pix); };
    const std::string error = error_of_capture(ms(1));
    EXPECT_NE(error.find("; expected"), std::string::npos) << error;
  }
  device.adjust_format = [](v4l2_format&) {};
  device.modes = {{V4L2_PIX_FMT_YUYV, 7, 4}};
  EXPECT_NE(error_of_capture(ms(1)).find("impossible"), std::string::npos);  // half a pair of pixels
  // A name that is no text.
  device.modes = {{}};
  device.card = std::string(40, '\n');
  EXPECT_EQ(camera().name(), std::string(32, '?'));
}

TEST_F(V4l2FaultsTest, WhatGivesNoPicturesIsOneLine) {
  device.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_NE(error_of_capture().find("metadata"), std::string::npos);
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  EXPECT_NE(error_of_capture().find("multi-planar"), std::string::npos);
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE;
  EXPECT_NE(error_of_capture().find("no pictures by streaming"), std::string::npos);
  device.open_error = -EACCES;
  EXPECT_NE(error_of_capture().find("group 'video'"), std::string::npos);
}

TEST_F(V4l2FaultsTest, AnHourOfEverythingAtRandomIsCountedToTheLastPicture) {
  std::mt19937 random(11);
  const auto chance = [&](double probability) {
    return std::uniform_real_distribution<double>(0, 1)(random) < probability;
  };
  options.reopen = true;
  device.failed_dequeue_takes_buffer = true;
  device.make_frame = [&](SimulatedCamera& camera, std::uint32_t number) {
    Frame frame = SimulatedCamera::good_frame(camera, number);
    if (chance(0.01)) frame.bytes.resize(random() % frame.bytes.size());
    if (chance(0.01)) frame.bytes_used = static_cast<std::uint32_t>(random());
    if (chance(0.01)) frame.flags = V4L2_BUF_FLAG_ERROR;
    if (chance(0.01)) frame.stamp_us = static_cast<std::int64_t>(random());
    return frame;
  };
  V4l2Camera& source = camera();
  const Timestamp end = device.monotonic() + seconds(3600);
  std::size_t delivered = 0;
  while (device.monotonic() < end) {
    if (chance(0.002)) device.failing[VIDIOC_DQBUF].assign(random() % 30, -EIO);
    if (chance(0.001)) device.failing[VIDIOC_QBUF].assign(random() % 5, -EINVAL);
    if (chance(0.0005)) device.unplug();
    if (chance(0.02)) device.plug_in();
    if (chance(0.001)) device.is_silent = true;
    if (chance(0.01)) device.is_silent = false;
    if (chance(0.01)) device.interrupted_polls = 3;
    if (chance(0.02)) device.advance(ms(random() % 300));
    delivered += source.next(ms(random() % 100)).has_value();
    check_counts();
  }
  const auto& statistics = source.statistics();
  EXPECT_EQ(statistics.delivered, delivered);
  EXPECT_GT(delivered, 30000u);
  EXPECT_GT(statistics.unplugged, 10u);
  EXPECT_GT(statistics.reopened, 10u);
  EXPECT_GT(statistics.io_errors, 100u);
  EXPECT_GT(statistics.restarts, 10u);
  EXPECT_GT(statistics.flagged, 100u);
  EXPECT_GT(statistics.short_frames, 100u);
  EXPECT_GT(statistics.bad_stamps, 100u);
}

}  // namespace
}  // namespace foreview
