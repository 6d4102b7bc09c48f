#include "foreview/server/live_source.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <random>

#include "foreview/scene/errors.h"
#include "foreview/server/camera_info.h"
#include "live_robot.h"
#include "played_recording.h"

namespace foreview {
namespace {

using test::comes_true;
using test::LiveRobot;
using test::milliseconds;
using test::settled;
using test::take_soon;

void expect_balance(LiveSource& source) {
  const SourceStatus status = source.status();
  EXPECT_EQ(status.pictures_in, status.used + status.overwritten + status.damaged + status.stateless);
}

TEST(LiveSource, OffersPicturesWithPoseAndModel) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 0; i < 5; ++i) {
    robot.send_picture(i);
    EXPECT_FALSE(robot.source.take());  // its pose is not known yet
    robot.send_pose(i);
    const auto frame = take_soon(robot.source);
    ASSERT_TRUE(robot.is_picture(frame, i));
    EXPECT_EQ(frame->index, static_cast<std::size_t>(i));
  }
  EXPECT_EQ(robot.source.status().used, 5U);
  EXPECT_EQ(robot.source.status().newest_capture, robot.stamp(4));
  expect_balance(robot.source);
  ASSERT_TRUE(robot.source.predicted_state(robot.stamp(99)));
  EXPECT_EQ(robot.source.predicted_state(robot.stamp(99))->stamp, robot.stamp(4));  // the newest known
  EXPECT_NEAR(robot.source.predicted_state(robot.stamp(2))->world_from_camera.translation.x, 2, 1e-9);
}

TEST(LiveSource, PicturesWithoutStateAreDroppedAfterABoundedWait) {
  LiveRobot robot;
  robot.send_picture(0);  // no camera_info
  ASSERT_TRUE(comes_true([&] { return robot.source.status().stateless == 1; }));
  robot.send_info();
  robot.send_picture(1);  // no pose
  ASSERT_TRUE(comes_true([&] { return robot.source.status().stateless == 2; }));
  robot.send_pose(1);
  robot.send_pose(2);
  robot.send_picture(2);
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 2));
  expect_balance(robot.source);
}

TEST(LiveSource, NewestWinsAndEveryPictureIsCounted) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 0; i < 30; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
  }
  ASSERT_TRUE(settled(robot.source));
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 29));
  EXPECT_FALSE(robot.source.take());
  EXPECT_EQ(robot.source.status().pictures_in, 30U);
  expect_balance(robot.source);
}

TEST(LiveSource, PartsFollowTheirFrames) {
  LiveRobot robot;
  robot.send_info();
  robot.send_pose(0);
  robot.send_part(0, 5);
  robot.send_picture(0);
  const auto frame = take_soon(robot.source);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->frame.state.world_from_part.size(), 2U);
  EXPECT_EQ(frame->frame.state.world_from_part[0], Pose());
  EXPECT_EQ(frame->frame.state.world_from_part[1].translation.y, 5);
  // From now on pictures wait for it.
  robot.send_pose(1);
  robot.send_picture(1);
  ASSERT_TRUE(comes_true([&] { return robot.source.status().stateless == 1; }));
}

TEST(LiveSource, PoseTopicStandsInForTf) {
  LiveRobot robot({}, true);
  robot.send_info();
  robot.source.on_pose(0, {{robot.stamp(0), "world"}, Pose{{1, 0, 0, 0}, {0, 0, 0}}});
  robot.send_picture(0);
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 0));
}

TEST(LiveSource, EveryTenthJpegCorruptedIsCountedAndTheRestShown) {
  LiveRobot robot;
  robot.send_info();
  std::size_t shown = 0;
  for (int i = 0; i < 50; ++i) {
    robot.send_pose(i);
    robot.send_picture(i, [&](CompressedImageMessage& message) {
      if (i % 10 == 3) message.data.resize(message.data.size() / 2);
      if (i % 20 == 13) message.data.assign(500, 0xff);
    });
    if (i % 10 == 3) {
      ASSERT_TRUE(settled(robot.source));
      EXPECT_FALSE(robot.source.take());
    } else {
      ASSERT_TRUE(robot.is_picture(take_soon(robot.source), i));
      ++shown;
    }
  }
  EXPECT_EQ(shown, 45U);
  EXPECT_EQ(robot.source.status().damaged, 5U);
  expect_balance(robot.source);
}

TEST(LiveSource, DuplicatesAreShownOnce) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 0; i < 10; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    robot.send_picture(i);
    ASSERT_TRUE(robot.is_picture(take_soon(robot.source), i));
    ASSERT_TRUE(settled(robot.source));
    EXPECT_FALSE(robot.source.take());
  }
  EXPECT_EQ(robot.source.status().duplicated, 10U);
  expect_balance(robot.source);
}

TEST(LiveSource, CameraInfoOfAnotherSizeInMidStream) {
  LiveRobot robot;
  robot.send_info();
  robot.send_pose(0);
  robot.send_picture(0);
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 0));
  robot.size = {48, 32};
  robot.send_pose(1);
  robot.send_picture(1);  // before its camera_info
  ASSERT_TRUE(comes_true([&] { return robot.source.status().damaged == 1; }));
  robot.send_info();
  robot.send_pose(2);
  robot.send_picture(2);
  const auto frame = take_soon(robot.source);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.picture.size(), cv::Size(48, 32));
  EXPECT_EQ(frame->frame.camera.width, 48);
  CameraInfoMessage bad = info_from_camera(frame->frame.camera);
  bad.k = {};
  robot.source.on_camera_info(0, bad);  // refused; the last one holds
  robot.send_pose(3);
  robot.send_picture(3);
  EXPECT_TRUE(take_soon(robot.source));
}

TEST(LiveSource, RestartedSenderIsANewGeneration) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 500; i < 503; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    ASSERT_TRUE(robot.is_picture(take_soon(robot.source), i));
  }
  EXPECT_EQ(robot.source.generation(), 0U);
  std::optional<IncomingFrame> frame;
  for (int i = 0; i < 20 && !frame; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    robot.send_pose(i);
    ASSERT_TRUE(settled(robot.source));
    frame = robot.source.take();
  }
  ASSERT_TRUE(frame);
  EXPECT_EQ(robot.source.generation(), 1U);
  EXPECT_EQ(frame->generation, 1U);
  EXPECT_LT(frame->frame.state.stamp, robot.stamp(20));
  expect_balance(robot.source);
}

TEST(LiveSource, SenderRestartedWithStampsALittleBackIsANewGeneration) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 100; i < 120; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    ASSERT_TRUE(robot.is_picture(take_soon(robot.source), i));
  }
  // Begins anew 0.7 s back, where the first one's poses are known: none of them may be used.
  robot.publisher = 2;
  std::optional<IncomingFrame> frame;
  int i = 113;
  for (; i < 160 && !frame; ++i) {
    robot.source.on_transforms({{{{robot.stamp(i), "world"}, "optical", Pose{{1, 0, 0, 0}, {-1.0 * i, 0, 0}}}}}, false);
    robot.send_picture(i);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ASSERT_TRUE(settled(robot.source));
    frame = robot.source.take();
  }
  ASSERT_TRUE(frame);
  EXPECT_EQ(robot.source.generation(), 1U);
  EXPECT_EQ(frame->generation, 1U);
  EXPECT_EQ(frame->frame.state.stamp, robot.stamp(i - 1));
  EXPECT_EQ(frame->frame.state.world_from_camera.translation.x, -(i - 1));
  expect_balance(robot.source);
}

TEST(LiveSource, GarbageThatIsNewerDisplacesNoPicture) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 0; i < 20; ++i) {
    robot.send_pose(i);
    // Begins as a JPEG and ends as one: found out only where it is decoded, before the older picture if it can be.
    robot.send_picture(2 * i + 1, [](CompressedImageMessage& message) {
      for (std::size_t k = 20; k < 200; ++k) message.data[k] = static_cast<std::uint8_t>(k * 31);
    });
    robot.send_picture(2 * i);
    robot.send_pose(2 * i);
    robot.send_pose(2 * i + 1);
    ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 2 * i)) << i;
    ASSERT_TRUE(settled(robot.source));
  }
  EXPECT_EQ(robot.source.status().damaged, 20U);
  expect_balance(robot.source);
}

TEST(LiveSource, AFloodOfAnotherPublisherDisplacesNoPicture) {
  LiveSource::Options options;
  options.most_waiting = 20;
  options.link.delay = milliseconds(300);  // all of them wait together
  LiveRobot robot(options);
  robot.send_info();
  robot.send_pose(0);
  robot.send_picture(0);
  robot.publisher = 2;
  for (int i = 0; i < 200; ++i) robot.send_picture(100'000 + i);
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 0));
  ASSERT_TRUE(settled(robot.source));
  EXPECT_EQ(robot.source.generation(), 0U);
  expect_balance(robot.source);
}

TEST(LiveSource, LossJitterAndReorderingOverTheSimulatedLink) {
  LiveSource::Options options;
  options.link.delay = milliseconds(60);
  options.link.jitter = milliseconds(40);
  options.link.loss = 0.2;
  LiveRobot robot(options);
  robot.send_info();
  std::size_t taken = 0;
  for (int i = 0; i < 150; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    std::this_thread::sleep_for(std::chrono::milliseconds(4));
    while (const auto frame = robot.source.take()) {
      ++taken;
      ASSERT_TRUE(robot.is_picture(frame, static_cast<int>((frame->frame.state.stamp - robot.stamp(0)).nanoseconds /
                                                           LiveRobot::kPeriod.nanoseconds)));
    }
  }
  ASSERT_TRUE(settled(robot.source));
  while (robot.source.take()) ++taken;
  const SourceStatus status = robot.source.status();
  EXPECT_EQ(status.pictures_in + status.lost, 150U);
  EXPECT_NEAR(static_cast<double>(status.lost), 30, 15);
  EXPECT_EQ(status.used, taken);
  EXPECT_GT(taken, 10U);
  expect_balance(robot.source);
}

TEST(LiveSource, SilenceShowsInTheStatusAndEnds) {
  LiveRobot robot;
  robot.send_info();
  robot.send_pose(0);
  robot.send_picture(0);
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 0));
  // 30 s of silence, as if our clock had gone on.
  EXPECT_NEAR((robot.source.time_at(steady_now() + milliseconds(30'000)) - robot.stamp(0)).seconds(), 30, 5);
  const SourceStatus status = robot.source.status();
  EXPECT_EQ(status.newest_capture, robot.stamp(0));
  robot.send_pose(300);
  robot.send_picture(300);
  ASSERT_TRUE(robot.is_picture(take_soon(robot.source), 300));
  EXPECT_EQ(robot.source.generation(), 0U);
}

TEST(LiveSource, GarbageNeitherStopsNorFillsIt) {
  LiveSource::Options options;
  options.waiting_bytes = 1 << 20;
  LiveRobot robot(options);
  std::mt19937 random(9);
  robot.send_info();
  for (int i = 0; i < 400; ++i) {
    CompressedImageMessage garbage{{{static_cast<std::int64_t>(random()) << 31}, "optical"}, "jpeg", {}};
    garbage.data.resize(random() % 60'000);
    for (auto& byte : garbage.data) byte = static_cast<std::uint8_t>(random());
    robot.source.on_picture(0, std::move(garbage), robot.reception());
    CameraInfoMessage info;
    info.width = static_cast<std::uint32_t>(random());
    info.d.assign(random() % 100, 1e300);
    robot.source.on_camera_info(0, info);
    robot.source.on_transforms({{{{{}, "a" + std::to_string(i)}, "b", Pose()}}}, false);
  }
  ASSERT_TRUE(settled(robot.source));
  robot.send_pose(0);
  robot.send_picture(0);
  std::optional<IncomingFrame> frame;
  // The garbage's stamps may have begun streams of their own.
  for (int i = 0; i < 20 && !frame; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    robot.send_pose(i + 1);
    ASSERT_TRUE(settled(robot.source));
    frame = robot.source.take();
  }
  EXPECT_TRUE(frame);
  expect_balance(robot.source);
}

TEST(LiveSource, ReaderDoesNotWaitForASlowDecoder) {
  LiveRobot robot;
  robot.size = {4000, 3000};
  robot.send_info();
  cv::Mat noise(robot.size, CV_8UC3);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  std::vector<std::uint8_t> encoded;
  cv::imencode(".jpg", noise, encoded);
  // There is always a picture to decode, and a reader who asks all that a display asks, as fast as it can.
  std::vector<Duration> waits;
  std::size_t while_decoding = 0;
  int sent = 0;
  std::size_t taken = 0;
  while (taken < 5) {
    if (!robot.source.status().is_decoding) {
      robot.send_pose(sent);
      robot.source.on_picture(0, CompressedImageMessage{{LiveRobot::stamp(sent), "optical"}, "jpeg", encoded},
                              robot.reception());
      ASSERT_LT(++sent, 100);
    }
    const Timestamp begun = steady_now();
    if (robot.source.take()) ++taken;
    const SourceStatus status = robot.source.status();
    static_cast<void>(robot.source.predicted_state(robot.source.time_at(begun)));
    static_cast<void>(robot.source.camera_model(0));
    waits.push_back(steady_now() - begun);
    if (status.is_decoding) ++while_decoding;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  std::sort(waits.begin(), waits.end());
  const Duration decoding = robot.source.latency().decoding_median, p95 = waits[waits.size() * 95 / 100];
  const auto ms = [](Duration duration) { return static_cast<double>(duration.nanoseconds) * 1e-6; };
  std::printf(
      "decoding %.1f ms; %zu asked meanwhile; waited: median %.4f ms, p95 %.4f ms, p99 %.3f ms, longest %.2f ms\n",
      ms(decoding), while_decoding, ms(waits[waits.size() / 2]), ms(p95), ms(waits[waits.size() * 99 / 100]),
      ms(waits.back()));
  RecordProperty("decoding_us", static_cast<int>(ms(decoding) * 1000));
  RecordProperty("wait_p99_us", static_cast<int>(ms(waits[waits.size() * 99 / 100]) * 1000));
  ASSERT_GT(decoding, milliseconds(10));
  EXPECT_GT(while_decoding, 20U);
  EXPECT_LT(p95.nanoseconds, decoding.nanoseconds / 4);
  ASSERT_TRUE(settled(robot.source));
  static_cast<void>(robot.source.take());
  expect_balance(robot.source);
}

TEST(LiveSource, CountsByCameraWhatBecameOfPictures) {
  LiveSource::Options options;
  options.cameras = {{"left", "optical", false}, {"right", "elsewhere", false}};
  LiveSource source(options);
  const LiveRobot robot;  // for its messages
  CameraModel camera;
  camera.width = 32;
  camera.height = 24;
  camera.focal_length = {30, 30};
  camera.principal_point = {16, 12};
  for (const std::size_t c : {0, 1}) source.on_camera_info(c, info_from_camera(camera));
  for (int i = 0; i < 4; ++i) {
    source.on_transforms({{{{LiveRobot::stamp(i), "world"}, "optical", Pose()}}}, false);
    for (const std::size_t c : {0, 1}) {
      CompressedImageMessage message{{LiveRobot::stamp(i), c == 0 ? "optical" : "elsewhere"}, "jpeg", {}};
      cv::imencode(".jpg", cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(9)), message.data);
      if (i == 3 && c == 0) message.data.resize(message.data.size() / 2);
      source.on_picture(c, message, robot.reception());
      if (i == 1) source.on_picture(c, message, robot.reception());
    }
    ASSERT_TRUE(settled(source));
    if (i != 1) static_cast<void>(source.take());
  }
  const SourceStatus status = source.status();
  ASSERT_EQ(status.cameras.size(), 2U);
  const PictureCounts &left = status.cameras[0], &right = status.cameras[1];
  EXPECT_EQ(left.in, 4U);
  EXPECT_EQ(left.used, 2U);
  EXPECT_EQ(left.overwritten, 1U);
  EXPECT_EQ(left.damaged, 1U);
  EXPECT_EQ(left.stateless, 0U);
  EXPECT_EQ(left.duplicated, 1U);
  EXPECT_EQ(right.in, 4U);
  EXPECT_EQ(right.stateless, 4U) << "its frame is not known";
  EXPECT_EQ(right.used + right.damaged + right.overwritten, 0U);
  EXPECT_EQ(status.pictures_in, 8U);
  EXPECT_EQ(status.duplicated, 2U);
  EXPECT_EQ(status.stateless, 4U);
}

TEST(LiveSource, IsHeardByWhateverComes) {
  LiveRobot robot;
  EXPECT_TRUE(robot.source.is_live());
  EXPECT_FALSE(robot.source.status().last_heard);
  robot.send_pose(0);
  const SourceStatus first = robot.source.status();
  ASSERT_TRUE(first.last_heard);
  EXPECT_LT((first.now - *first.last_heard).seconds(), 5);
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  const SourceStatus silent = robot.source.status();
  EXPECT_GE(silent.now - *silent.last_heard, milliseconds(30)) << "silence is not life";
  robot.send_info();
  EXPECT_LT(robot.source.status().now - *robot.source.status().last_heard,
            silent.now - *silent.last_heard + milliseconds(30));
  EXPECT_GT(*robot.source.status().last_heard, *silent.last_heard);
}

TEST(LiveSource, MeasuresLatency) {
  LiveRobot robot;
  robot.send_info();
  for (int i = 0; i < 20; ++i) {
    robot.send_pose(i);
    robot.send_picture(i);
    ASSERT_TRUE(take_soon(robot.source));
  }
  const LiveSource::Latency latency = robot.source.latency();
  EXPECT_EQ(latency.pictures, 20U);
  EXPECT_GT(latency.median.nanoseconds, 0);
  EXPECT_GE(latency.p99, latency.median);
  EXPECT_GT(latency.decoding_share, 0);
  EXPECT_LE(latency.decoding_share, 1);
}

TEST(LiveSource, StandsSendersAndReadersAtOnce) {
  LiveRobot robot;
  std::atomic<bool> stops{false};
  std::thread reader([&] {
    while (!stops) {
      static_cast<void>(robot.source.take());
      static_cast<void>(robot.source.status());
      static_cast<void>(robot.source.predicted_state(robot.source.time_at(steady_now())));
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  });
  std::thread poses([&] {
    for (int i = 0; i < 200; ++i) robot.send_pose(i);
  });
  for (int i = 0; i < 200; ++i) {
    robot.send_info();
    robot.send_picture(i);
  }
  poses.join();
  ASSERT_TRUE(settled(robot.source));
  stops = true;
  reader.join();
  while (robot.source.take()) {
  }
  expect_balance(robot.source);
}

}  // namespace
}  // namespace foreview
