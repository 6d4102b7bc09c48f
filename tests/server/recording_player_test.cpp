#include "foreview/server/recording_player.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "foreview/scene/errors.h"
#include "played_recording.h"

namespace foreview {
namespace {

using test::comes_true;
using test::is_picture;
using test::milliseconds;
using test::PlayedRecording;
using test::SimulatedTime;
using test::take_soon;

/// A recording that is played in simulated time.
struct Played {
  explicit Played(int count, RecordingPlayer::Options options = {}, int cameras = 1, bool loop = false,
                  const std::function<void(const Recording&)>& prepare = {})
      : recorded(count, cameras),
        recording(opened(recorded, prepare)),
        clock({recording.first_stamp(), recording.last_stamp(), 1, loop}, real.source()),
        player(recording, model, clock, options) {}

  static Recording opened(const PlayedRecording& recorded, const std::function<void(const Recording&)>& prepare) {
    Recording recording = recorded.open();
    if (prepare) prepare(recording);
    return recording;
  }
  /// Waits until all is decoded that can be now.
  void settle() {
    ASSERT_TRUE(comes_true([&] { return !player.status().is_decoding; }));
  }
  /// Display time is this much after the first picture's capture.
  void go_to(Duration since_first) {
    settle();
    real.advance(since_first + Duration{-(clock.now().time - clock.first()).nanoseconds});
  }

  PlayedRecording recorded;
  Recording recording;
  PolygonModel model = test::one_triangle();
  SimulatedTime real;
  PlaybackClock clock;
  RecordingPlayer player;
};

RecordingPlayer::Options with_delay(std::int64_t ms) {
  RecordingPlayer::Options options;
  options.link.delay = milliseconds(ms);
  return options;
}

/// Every picture that arrived is accounted for.
void expect_balance(const SourceStatus& status) {
  EXPECT_EQ(status.pictures_in, status.used + status.overwritten + status.damaged + status.stateless);
}

TEST(RecordingPlayer, EveryPictureArrivesAfterItsDelay) {
  Played played(5, with_delay(150));
  EXPECT_FALSE(played.player.take());
  played.go_to(milliseconds(150));
  EXPECT_EQ(played.player.status().pictures_in, 0U);  // known after its delay, not at it: as replay does
  for (int i = 0; i < 3; ++i) {
    played.go_to(milliseconds(151 + 100 * i));
    const auto frame = take_soon(played.player);
    ASSERT_TRUE(is_picture(frame, i));
    EXPECT_EQ(frame->received, PlayedRecording::stamp(i) + milliseconds(150));
    EXPECT_EQ(frame->generation, 0U);
    EXPECT_FALSE(frame->is_history);
    EXPECT_FALSE(played.player.take());
  }
  const SourceStatus status = played.player.status();
  EXPECT_EQ(status.used, 3U);
  EXPECT_EQ(status.newest_capture, PlayedRecording::stamp(2));
  EXPECT_EQ(status.last_received, PlayedRecording::stamp(2) + milliseconds(150));
  EXPECT_EQ(status.now, PlayedRecording::kFirst + milliseconds(351));
  EXPECT_EQ(status.expected_delay, milliseconds(150));
  expect_balance(status);
}

TEST(RecordingPlayer, NewestWinsAndTheRestIsCounted) {
  Played played(8, with_delay(0));
  played.go_to(milliseconds(501));
  ASSERT_TRUE(is_picture(take_soon(played.player), 5));
  EXPECT_FALSE(played.player.take());
  const SourceStatus status = played.player.status();
  EXPECT_EQ(status.pictures_in, 6U);
  EXPECT_EQ(status.used, 1U);
  EXPECT_EQ(status.overwritten, 5U);
}

TEST(RecordingPlayer, CamerasTakeTurns) {
  Played played(4, with_delay(0), 2);
  played.go_to(milliseconds(120));  // both have an unread picture
  ASSERT_TRUE(comes_true([&] { return played.player.status().bytes_decoded > 0; }));
  const auto first = take_soon(played.player), second = take_soon(played.player);
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->camera, second->camera);
  EXPECT_TRUE(is_picture(first->camera == 0 ? first : second, 1, 0));
  EXPECT_TRUE(is_picture(first->camera == 1 ? first : second, 0, 1));
  EXPECT_EQ(played.player.cameras(), 2U);
  EXPECT_EQ(played.player.camera_model(1)->name, "camera1");
}

TEST(RecordingPlayer, SeekVoidsWhatArrivedAndSendsTheNewestFirstThenHistory) {
  auto options = with_delay(100);
  options.history = 3;
  Played played(10, options);
  played.go_to(milliseconds(201));
  ASSERT_TRUE(is_picture(take_soon(played.player), 1));
  played.clock.seek(PlayedRecording::stamp(7) + milliseconds(50));
  EXPECT_EQ(played.player.generation(), 1U);
  for (int i = 6; i >= 3; --i) {
    const auto frame = take_soon(played.player);
    ASSERT_TRUE(is_picture(frame, i));
    EXPECT_EQ(frame->generation, 1U);
    EXPECT_EQ(frame->is_history, i < 6);
  }
  EXPECT_FALSE(played.player.take());
  const SourceStatus status = played.player.status();
  EXPECT_EQ(status.pictures_in, 3U);  // 0, 1, and after the seek 6
  EXPECT_EQ(status.history, 3U);
  EXPECT_EQ(status.newest_capture, PlayedRecording::stamp(6));
  expect_balance(status);
  // Backwards, too.
  played.clock.seek(PlayedRecording::stamp(2));
  played.settle();
  ASSERT_TRUE(is_picture(take_soon(played.player), 0));
  EXPECT_FALSE(played.player.take());
}

TEST(RecordingPlayer, NewArrivalsGoBeforeHistory) {
  auto options = with_delay(0);
  options.history = 4;
  Played played(10, options);
  played.clock.pause();
  played.clock.seek(PlayedRecording::stamp(5) + milliseconds(1));
  ASSERT_TRUE(is_picture(take_soon(played.player), 5));
  ASSERT_TRUE(is_picture(take_soon(played.player), 4));
  played.clock.play();
  played.real.advance(milliseconds(100));
  ASSERT_TRUE(comes_true([&] { return played.player.status().bytes_decoded >= 3 * 16 * 12 * 3; }));
  ASSERT_TRUE(is_picture(take_soon(played.player), 6));
  ASSERT_TRUE(is_picture(take_soon(played.player), 3));
}

TEST(RecordingPlayer, LoopIsANewGeneration) {
  Played played(3, with_delay(50), 1, true);
  played.settle();
  played.real.advance(milliseconds(160));
  ASSERT_TRUE(is_picture(take_soon(played.player), 1));
  played.real.advance(milliseconds(60));  // 220: once round, at 20
  EXPECT_EQ(played.player.status().generation, 1U);
  EXPECT_FALSE(played.player.take());
  EXPECT_FALSE(played.player.status().newest_capture);
  played.real.advance(milliseconds(60));
  const auto frame = take_soon(played.player);
  ASSERT_TRUE(is_picture(frame, 0));
  EXPECT_EQ(frame->generation, 1U);
}

TEST(RecordingPlayer, AnotherDelayHoldsForPicturesUnderWay) {
  Played played(30, with_delay(1000));
  played.go_to(milliseconds(1101));
  ASSERT_TRUE(is_picture(take_soon(played.player), 1));
  played.player.set_link({.delay = milliseconds(300)});
  played.settle();  // else 7, decoded ahead, comes before 8 is decoded
  ASSERT_TRUE(is_picture(take_soon(played.player), 8));
  EXPECT_EQ(played.player.status().overwritten, 7U);  // 0, and 2 to 7
  played.player.set_link({.delay = milliseconds(1000)});
  played.go_to(milliseconds(1801));
  EXPECT_FALSE(played.player.take());  // 8 has arrived already; nothing arrives twice
  EXPECT_EQ(played.player.status().pictures_in, 9U);
  played.go_to(milliseconds(1901));
  ASSERT_TRUE(is_picture(take_soon(played.player), 9));
  EXPECT_THROW(played.player.set_link({.loss = 2}), InputError);
  EXPECT_EQ(played.player.link().delay, milliseconds(1000));
}

TEST(RecordingPlayer, LossesAreCountedAndWhatWasLostStaysLost) {
  RecordingPlayer::Options options;
  options.link.loss = 0.5;
  Played played(60, options);
  std::size_t taken = 0;
  for (int i = 0; i < 50; ++i) {
    played.go_to(milliseconds(100 * i + 1));
    const std::size_t in = played.player.status().pictures_in;
    if (in > taken) {
      ASSERT_TRUE(is_picture(take_soon(played.player), i));
      ++taken;
    }
  }
  EXPECT_GT(taken, 15U);
  EXPECT_LT(taken, 35U);
  EXPECT_EQ(played.player.status().lost + taken, 50U);
  played.player.set_link({});
  EXPECT_EQ(played.player.status().pictures_in, taken);
  EXPECT_EQ(played.player.status().lost + taken, 50U);
}

TEST(RecordingPlayer, LatePictureIsOfferedAfterANewerWasTaken) {
  RecordingPlayer::Options options;
  options.link.reordering = 0.3;
  options.link.reordering_delay = milliseconds(150);
  Played played(40, options);
  std::size_t late = 0, taken = 0;
  Timestamp newest;
  for (std::int64_t t = 1; t < 3800; t += 10) {
    played.go_to(milliseconds(t));
    while (played.player.status().pictures_in > taken) {
      const auto frame = take_soon(played.player);
      ASSERT_TRUE(frame);
      ASSERT_TRUE(is_picture(frame, static_cast<int>(frame->index)));
      ++taken;
      late += frame->frame.state.stamp < newest;
      newest = std::max(newest, frame->frame.state.stamp);
    }
  }
  EXPECT_GT(late, 5U);
  EXPECT_EQ(played.player.status().overwritten, 0U);
}

TEST(RecordingPlayer, DamagedPicturesAreDroppedAndCounted) {
  Played played(6, {}, 1, false, [](const Recording& recording) {
    std::ofstream(recording.cameras()[0].pictures[3].file) << "no picture";
  });
  for (int i = 0; i < 5; ++i) {
    played.go_to(milliseconds(100 * i + 1));
    EXPECT_EQ(played.player.status().damaged, i < 3 ? 0U : 1U);
    if (i != 3) {
      ASSERT_TRUE(is_picture(take_soon(played.player), i));
    } else {
      EXPECT_FALSE(played.player.take());
    }
  }
  EXPECT_EQ(played.player.status().error, "");
  expect_balance(played.player.status());
}

TEST(RecordingPlayer, DeletedRecordingIsAnErrorNotTheEnd) {
  auto options = with_delay(0);
  options.decoded_ahead = 1;
  Played played(20, options);
  played.go_to(milliseconds(1));
  ASSERT_TRUE(is_picture(take_soon(played.player), 0));
  std::filesystem::rename(played.recorded.path(), played.recorded.directory / "elsewhere");
  played.go_to(milliseconds(1001));
  ASSERT_TRUE(comes_true([&] { return !played.player.status().error.empty(); }));
  EXPECT_NE(played.player.status().error.find("the recording is gone"), std::string::npos);
  // It comes back.
  std::filesystem::rename(played.recorded.directory / "elsewhere", played.recorded.path());
  std::optional<IncomingFrame> frame;
  ASSERT_TRUE(comes_true([&] {
    frame = played.player.take();
    if (frame && frame->index > 10) return true;
    played.real.advance(milliseconds(1));
    return false;
  }));
  EXPECT_EQ(played.player.status().error, "");
}

TEST(RecordingPlayer, DecodesAheadInBoundedMemory) {
  constexpr std::size_t kPicture = 16 * 12 * 3;
  auto options = with_delay(1000);
  options.decoded_ahead = 100;
  options.decoded_bytes = 5 * kPicture + 10;
  Played played(30, options);
  ASSERT_TRUE(comes_true([&] { return played.player.status().bytes_decoded == 5 * kPicture; }));
  std::size_t taken = 0;
  for (std::int64_t t = 1001; t < 2900; t += 100) {
    played.go_to(milliseconds(t));
    EXPECT_LE(played.player.status().bytes_decoded, 6 * kPicture);
    ASSERT_TRUE(take_soon(played.player));
    ++taken;
  }
  EXPECT_EQ(taken, 19U);
}

TEST(RecordingPlayer, TellsTheEnd) {
  Played played(3);
  EXPECT_FALSE(played.player.status().ended);
  played.go_to(milliseconds(5000));
  EXPECT_EQ(played.clock.now().time, PlayedRecording::stamp(2));
  ASSERT_TRUE(is_picture(take_soon(played.player), 1));
  ASSERT_TRUE(comes_true([&] { return played.player.status().ended; }));
  EXPECT_TRUE(played.player.predicted_state(PlayedRecording::stamp(1) + milliseconds(50)));
  EXPECT_NEAR(played.player.predicted_state(PlayedRecording::stamp(1))->world_from_camera.translation.x, 0.1, 1e-12);
  EXPECT_FALSE(played.player.predicted_state(PlayedRecording::stamp(9)));
}

TEST(RecordingPlayer, RefusesACameraThatIsNotThere) {
  const PlayedRecording recorded(2);
  const Recording recording = recorded.open();
  const PolygonModel model = test::one_triangle();
  PlaybackClock clock({recording.first_stamp(), recording.last_stamp()});
  RecordingPlayer::Options options;
  options.camera = 1;
  EXPECT_THROW(RecordingPlayer(recording, model, clock, options), InputError);
}

// For ThreadSanitizer: everything at once.
TEST(RecordingPlayer, StandsSeeksSlidersAndReadersAtOnce) {
  auto options = with_delay(20);
  options.history = 5;
  const PlayedRecording recorded(40, 2);
  const Recording recording = recorded.open();
  const PolygonModel model = test::one_triangle();
  PlaybackClock clock({recording.first_stamp(), recording.last_stamp(), 8, true});
  RecordingPlayer player(recording, model, clock, options);
  std::atomic<bool> stops{false};
  std::thread user([&] {
    for (int i = 0; i < 60; ++i) {
      clock.seek(PlayedRecording::stamp(i % 37));
      player.set_link({.delay = milliseconds(i * 7 % 90), .jitter = milliseconds(30), .loss = 0.1});
      if (i % 3 == 0) clock.pause();
      if (i % 3 == 1) clock.play();
      clock.set_speed(1 + i % 10);
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    stops = true;
  });
  std::uint64_t generation = 0;
  std::size_t taken = 0;
  while (!stops || taken == 0) {
    if (const auto frame = player.take()) {
      ++taken;
      EXPECT_TRUE(is_picture(frame, static_cast<int>(frame->index), static_cast<int>(frame->camera)));
      EXPECT_GE(frame->generation, generation);
      generation = frame->generation;
    }
    static_cast<void>(player.status());
    static_cast<void>(player.predicted_state(player.time_at(steady_now())));
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
  user.join();
  EXPECT_GT(taken, 5U);
}

}  // namespace
}  // namespace foreview
