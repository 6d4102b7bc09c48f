#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>

#include "child_process.h"
#include "dds_test_domain.h"
#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"
#include "foreview/server/recording_player.h"
#include "foreview/server/recording_sender.h"
#include "foreview/server/republisher.h"
#include "foreview/server/stream_recorder.h"
#include "played_recording.h"

namespace foreview {
namespace {

using test::Child;
using test::comes_true;
using test::milliseconds;
using test::PlayedRecording;

void send(const Recording& recording, int domain, RecordingSender::Options options) {
  DdsNode node({domain});
  RecordingSender sender(recording, node, std::move(options));
  if (!comes_true([&] { return sender.is_heard(); })) _exit(1);
  sender.run([] { return true; });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
}

std::vector<CameraTopics> topics_of(const Recording& recording) {
  std::vector<CameraTopics> topics;
  for (const Recording::Camera& camera : recording.cameras()) {
    topics.push_back(camera_topics(RecordingSender::image_topic(camera.name)));
  }
  return topics;
}

LiveSource::Options options_for(const Recording& recording) {
  LiveSource::Options options;
  for (const Recording::Camera& camera : recording.cameras()) options.cameras.push_back({camera.name, ""});
  return options;
}

/// All pictures that come until all have, or nothing does for two seconds.
std::map<std::pair<std::size_t, Timestamp>, IncomingFrame> collect(LiveSource& source, std::size_t expected) {
  std::map<std::pair<std::size_t, Timestamp>, IncomingFrame> frames;
  Timestamp last = steady_now() + milliseconds(20'000);
  while (frames.size() < expected && steady_now() - last < milliseconds(2000)) {
    if (auto frame = source.take()) {
      last = steady_now();
      frames.emplace(std::pair(frame->camera, frame->frame.state.stamp), std::move(*frame));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return frames;
}

TEST(LiveStreams, EveryPictureComesAsAReplayHasIt) {
  // The child begins before this process has threads; it waits until it is heard.
  const PlayedRecording recorded(12, 2);
  const Recording recording = recorded.open();
  const int domain = test::dds_domain();
  Child child([&] { send(recording, domain, {.keeps_stamps = true, .is_reliable = true}); });
  DdsNode node({domain});
  LiveSource source(options_for(recording));
  const LiveReceiver receiver(node, topics_of(recording), source);
  const auto frames = collect(source, 24);
  EXPECT_TRUE(child.wait());
  EXPECT_EQ(frames.size() + source.status().overwritten, 24U);
  EXPECT_GE(frames.size(), 20U);
  const PolygonModel model = test::one_triangle();
  for (const auto& [key, live] : frames) {
    const auto index = static_cast<std::size_t>((key.second - PlayedRecording::stamp(0)).nanoseconds / 100'000'000);
    const auto state = recording.capture_state(key.first, key.second, model);
    ASSERT_TRUE(state);
    EXPECT_EQ(live.frame.state.world_from_camera, state->world_from_camera);
    EXPECT_EQ(cv::norm(live.frame.picture, recording.read_picture(key.first, index), cv::NORM_INF), 0);
    EXPECT_EQ(live.frame.camera.principal_point, recording.cameras()[key.first].model.principal_point);
  }
  const SourceStatus status = source.status();
  EXPECT_EQ(status.pictures_in, status.used + status.overwritten + status.damaged + status.stateless);
}

TEST(LiveStreams, RestartedSenderIsHeardAgain) {
  const PlayedRecording recorded(40);
  const Recording recording = recorded.open();
  const int domain = test::dds_domain() + 1;
  // Both before this process has threads of DDS; the second begins when it is told to.
  Child first([&] { send(recording, domain, {}); });
  Child second([&] {
    if (!comes_true([&] { return std::filesystem::exists(recorded.directory / "go"); })) _exit(1);
    send(recording, domain, {});
  });
  DdsNode node({domain});
  LiveSource source(options_for(recording));
  const LiveReceiver receiver(node, topics_of(recording), source);
  ASSERT_TRUE(comes_true([&] { return source.take().has_value(); }));
  EXPECT_EQ(receiver.missing(), "");
  first.end(SIGKILL);
  recorded.directory.write("go", "");
  const std::size_t before = source.status().used;
  EXPECT_TRUE(comes_true([&] {
    while (source.take()) {
    }
    return source.status().used > before + 5;
  }));
}

TEST(LiveStreams, RecordingOfAStreamIsTheRecordingThatWasSent) {
  const PlayedRecording recorded(12, 2);
  const Recording recording = recorded.open();
  const int domain = test::dds_domain() + 2;
  const test::TemporaryDirectory directory;
  Child child([&] { send(recording, domain, {.keeps_stamps = true, .is_reliable = true}); });
  {
    DdsNode node({domain});
    StreamRecorder::Options options;
    options.directory = directory / "again";
    options.name = "again";
    for (const Recording::Camera& camera : recording.cameras()) options.cameras.push_back({camera.name, ""});
    StreamRecorder recorder(options);
    const LiveReceiver receiver(node, topics_of(recording), recorder);
    EXPECT_TRUE(comes_true([&] { return recorder.status().written == 24; })) << recorder.status().written;
    EXPECT_TRUE(child.wait());
    recorder.finish();
    EXPECT_EQ(recorder.status().error, "");
    EXPECT_EQ(recorder.status().pictures_in, 24U);
  }
  const Recording again = Recording::open(directory / "again");
  EXPECT_EQ(again.damage().total(), 0U);
  const PolygonModel model = test::one_triangle();
  ASSERT_EQ(again.cameras().size(), 2U);
  for (std::size_t c = 0; c < 2; ++c) {
    ASSERT_EQ(again.cameras()[c].pictures.size(), 12U);
    for (std::size_t i = 0; i < 12; ++i) {
      const Timestamp stamp = again.cameras()[c].pictures[i].stamp;
      EXPECT_EQ(stamp, PlayedRecording::stamp(static_cast<int>(i), static_cast<int>(c)));
      EXPECT_EQ(cv::norm(again.read_picture(c, i), recording.read_picture(c, i), cv::NORM_INF), 0);
      EXPECT_EQ(again.capture_state(c, stamp, model)->world_from_camera,
                recording.capture_state(c, stamp, model)->world_from_camera);
    }
  }
}

TEST(LiveStreams, RecordingIsReadableAfterKill) {
  const PlayedRecording recorded(60);
  const Recording recording = recorded.open();
  const int domain = test::dds_domain() + 3;
  const test::TemporaryDirectory directory;
  Child sender([&] { send(recording, domain, {.keeps_stamps = true}); });
  {
    Child recorder([&] {
      DdsNode node({domain});
      StreamRecorder::Options options;
      options.directory = directory / "cut";
      options.name = "cut";
      options.cameras = {{"camera", ""}};
      StreamRecorder writing(options);
      const LiveReceiver receiver(node, topics_of(recording), writing);
      std::this_thread::sleep_for(std::chrono::minutes(1));
    });
    EXPECT_TRUE(comes_true([&] { return std::filesystem::exists(directory / "cut/rgb/000010.png"); }));
    recorder.end(SIGKILL);
  }
  const Recording cut = Recording::open(directory / "cut");
  EXPECT_GE(cut.cameras()[0].pictures.size(), 10U);
  EXPECT_EQ(cut.damage().total(), 0U);
  for (std::size_t i = 0; i < cut.cameras()[0].pictures.size(); ++i) {
    EXPECT_EQ(cv::norm(cut.read_picture(0, i)(cv::Rect(0, 0, 1, 1)), cv::NORM_INF) > 0, true);
  }
}

TEST(LiveStreams, ServerHandsPicturesOnToAnotherDisplay) {
  const PlayedRecording recorded(10);
  const Recording recording = recorded.open();
  const int domain = test::dds_domain() + 4;
  Child robot([&] { send(recording, domain, {.keeps_stamps = true}); });
  DdsNode node({domain});
  LiveSource server(options_for(recording));
  Republisher republisher(node, {"camera"}, "world");
  LiveSource::Options display_options;
  display_options.cameras = {{"camera", "", true}};
  LiveSource display(display_options);
  const LiveReceiver at_display(
      node, {{"/foreview/camera/image_raw", "/foreview/camera/camera_info", "/foreview/camera/pose"}}, display);
  ASSERT_TRUE(comes_true([&] { return at_display.missing().empty(); })) << at_display.missing();
  const LiveReceiver at_server(node, topics_of(recording), server);
  std::optional<IncomingFrame> frame;
  ASSERT_TRUE(comes_true([&] {
    if (const auto served = server.take()) republisher.send(*served);
    frame = display.take();
    return frame.has_value();
  }));
  const auto index = static_cast<int>((frame->frame.state.stamp - PlayedRecording::kFirst).nanoseconds / 100'000'000);
  frame->index = static_cast<std::size_t>(index);
  EXPECT_TRUE(test::is_picture(frame, index));
}

}  // namespace
}  // namespace foreview
