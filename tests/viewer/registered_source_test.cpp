#include "foreview/viewer/registered_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <future>
#include <glm/geometric.hpp>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <random>
#include <thread>
#include <vector>

#include "calib/painted_room.h"
#include "foreview/server/recording_player.h"
#include "server/played_recording.h"

namespace foreview {
namespace {

using test::comes_true;
using test::is_picture;
using test::take_soon;

CameraModel small_camera() {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.focal_length = {260, 260};
  camera.principal_point = {160, 120};
  return camera;
}

Timestamp stamp_of(int picture) {
  return {1'000'000'000 + picture * 33'333'333LL};
}

Pose true_pose(int picture) {
  const double t = picture / 30.0;
  const glm::dvec3 eye(0.6 * std::sin(1.1 * t), 0.2 * std::sin(1.7 * t), -1.2 + 0.5 * std::sin(0.7 * t));
  return looking_at(eye, eye + glm::dvec3(0.6 * std::sin(0.8 * t), 0.2 * std::cos(t), 1), {0, -1, 0});
}

/// Gives the pictures that it is given, new ones before history; both in the order in which they came.
class ScriptedSource final : public FrameSource {
 public:
  explicit ScriptedSource(std::size_t cameras = 1) : cameras_(cameras) {}

  void give(IncomingFrame frame) {
    const std::lock_guard lock(mutex_);
    frame.generation = generation_;
    if (!frame.is_history) {
      ++status_.pictures_in;
      ++status_.cameras[frame.camera].in;
    }
    (frame.is_history ? history_ : arrived_).push_back(std::move(frame));
  }
  void begin_generation() {
    const std::lock_guard lock(mutex_);
    ++generation_;
    status_.overwritten += arrived_.size();
    for (const IncomingFrame& frame : arrived_) ++status_.cameras[frame.camera].overwritten;
    arrived_.clear();
    history_.clear();
  }
  /// How often it was asked in vain, for new pictures.
  [[nodiscard]] std::size_t asked_in_vain() const { return asked_in_vain_; }
  [[nodiscard]] SourceStatus own_status() {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  /// While somebody holds this, who takes pictures waits.
  std::mutex& gate() { return gate_; }
  [[nodiscard]] bool is_at_gate() const { return at_gate_; }

  std::optional<IncomingFrame> take() override { return take_of(true); }
  std::optional<IncomingFrame> take_new() override { return take_of(false); }
  std::optional<PredictedState> predicted_state(Timestamp t) const override {
    return PredictedState{t, Pose{{1, 0, 0, 0}, {t.seconds(), 2, 3}}, {Pose()}};
  }
  SourceStatus status() override { return own_status(); }
  Timestamp time_at(Timestamp steady) const override { return steady; }
  std::uint64_t generation() const override { return generation_; }
  std::size_t cameras() const override { return cameras_; }
  std::optional<CameraModel> camera_model(std::size_t) const override { return small_camera(); }

 private:
  std::optional<IncomingFrame> take_of(bool with_history) {
    at_gate_ = true;
    const std::lock_guard gate(gate_);
    at_gate_ = false;
    const std::lock_guard lock(mutex_);
    std::deque<IncomingFrame>& from = arrived_.empty() && with_history ? history_ : arrived_;
    if (arrived_.empty()) ++asked_in_vain_;
    if (from.empty()) return std::nullopt;
    IncomingFrame frame = std::move(from.front());
    from.pop_front();
    ++(frame.is_history ? status_.history : status_.used);
    if (!frame.is_history) ++status_.cameras[frame.camera].used;
    return frame;
  }

  const std::size_t cameras_;
  std::mutex mutex_, gate_;
  std::deque<IncomingFrame> arrived_, history_;
  SourceStatus status_ = [this] {
    SourceStatus status;
    status.cameras.resize(cameras_);
    return status;
  }();
  std::atomic<std::uint64_t> generation_{0};
  std::atomic<std::size_t> asked_in_vain_{0};
  std::atomic<bool> at_gate_{false};
};

/// A walk through the painted room whose mount and lens are not what is recorded. Its pictures take a while: one walk
/// for all tests.
class Walk {
 public:
  static constexpr int kPictures = 125, kUncorrected = 100;

  static const Walk& get() {
    static const Walk walk;
    return walk;
  }
  [[nodiscard]] const PolygonModel& model() const { return model_; }
  [[nodiscard]] IncomingFrame picture(int number, bool is_history = false) const {
    IncomingFrame incoming;
    incoming.frame.picture = pictures_[static_cast<std::size_t>(number)];
    incoming.frame.camera = small_camera();
    incoming.frame.camera.focal_length *= 1.03;
    const Pose recorded_from_true{glm::angleAxis(0.03, glm::normalize(glm::dvec3(0.3, 1, 0.2))), {0.03, -0.02, 0.02}};
    incoming.frame.state = {stamp_of(number), true_pose(number) * recorded_from_true.inverse(), {Pose()}};
    incoming.index = static_cast<std::size_t>(number);
    incoming.is_history = is_history;
    return incoming;
  }

 private:
  Walk() {
    for (int i = 0; i < kPictures; ++i) pictures_.push_back(room_.picture(small_camera(), true_pose(i)));
  }
  test::PaintedRoom room_;
  PolygonModel model_ = room_.model();
  std::vector<cv::Mat> pictures_;
};

/// A source that has learnt from the walk's pictures until it corrects them.
struct Learnt {
  Learnt() {
    for (; next < Walk::kUncorrected + 8; ++next) {
      source.give(walk.picture(next));
      last = take_soon(registered);
    }
  }
  /// Until pictures that were given are offered: who asks for more has done with them.
  [[nodiscard]] bool are_offered() {
    const std::size_t asked = source.asked_in_vain();
    return comes_true([&] { return source.asked_in_vain() > asked + 1; });
  }
  [[nodiscard]] Pose correction_of(const IncomingFrame& frame) const {
    return frame.frame.state.world_from_camera *
           walk.picture(static_cast<int>(frame.index)).frame.state.world_from_camera.inverse();
  }
  /// Whether the prediction is as that picture makes it out to be.
  [[nodiscard]] testing::AssertionResult predicts_by(const Pose& correction) const {
    const Timestamp t = stamp_of(300);
    const Pose predicted = registered.predicted_state(t)->world_from_camera,
               expected = correction * source.predicted_state(t)->world_from_camera;
    if (glm::distance(predicted.translation, expected.translation) < 1e-9 && angle_between(predicted, expected) < 1e-6)
      return testing::AssertionSuccess();
    return testing::AssertionFailure() << glm::distance(predicted.translation, expected.translation) << " m, "
                                       << angle_between(predicted, expected) << " rad off";
  }
  const Walk& walk = Walk::get();
  ScriptedSource source;
  RegisteredSource registered{source, walk.model(), 0};
  int next = 0;
  std::optional<IncomingFrame> last;
};

TEST(RegisteredSource, CorrectsAsRegistrationDoes) {
  const Walk& walk = Walk::get();
  const RayCaster rays(walk.model());
  Registration registration(walk.model(), rays);
  ScriptedSource source;
  RegisteredSource registered(source, walk.model(), 0);
  EXPECT_FALSE(registered.registered_camera());
  int corrected = 0;
  for (int i = 0; i < Walk::kUncorrected + 20; ++i) {
    source.give(walk.picture(i));
    const auto frame = take_soon(registered);
    ASSERT_TRUE(frame);
    IncomingFrame expected = walk.picture(i);
    if (expected.frame.state.world_from_camera != frame->frame.state.world_from_camera) ++corrected;
    registration.place(expected.frame);
    EXPECT_EQ(frame->index, static_cast<std::size_t>(i));
    EXPECT_EQ(frame->frame.state.world_from_camera, expected.frame.state.world_from_camera) << i;
    EXPECT_EQ(frame->frame.camera.focal_length, expected.frame.camera.focal_length) << i;
    EXPECT_EQ(registered.registered_camera()->focal_length, expected.frame.camera.focal_length) << i;
    EXPECT_EQ(registered.camera_model(0)->focal_length, small_camera().focal_length) << "stays as it is known without";
    registration.learn();
  }
  EXPECT_GT(corrected, 15);
  EXPECT_TRUE(registered.registration().is_correcting);
  EXPECT_GT(registered.registration().error_recorded, 1);
}

TEST(RegisteredSource, PredictsByThePictureThatWasTaken) {
  Learnt learnt;
  const Pose before = learnt.correction_of(*learnt.last);
  ASSERT_FALSE(learnt.predicts_by(Pose())) << "else this shows nothing";
  EXPECT_TRUE(learnt.predicts_by(before));
  learnt.source.give(learnt.walk.picture(learnt.next + 2));
  ASSERT_TRUE(learnt.are_offered());
  EXPECT_TRUE(learnt.predicts_by(before)) << "not yet taken";
  const auto frame = learnt.registered.take();
  ASSERT_TRUE(frame);
  const Pose now = learnt.correction_of(*frame);
  EXPECT_FALSE(learnt.predicts_by(before));
  EXPECT_TRUE(learnt.predicts_by(now));
  const auto camera = learnt.registered.registered_camera();
  EXPECT_EQ(camera->focal_length, frame->frame.camera.focal_length);
  // One that comes late is corrected, but says nothing newer.
  learnt.source.give(learnt.walk.picture(learnt.next));
  const auto late = take_soon(learnt.registered);
  ASSERT_TRUE(late);
  EXPECT_NE(late->frame.state.world_from_camera, learnt.walk.picture(learnt.next).frame.state.world_from_camera);
  EXPECT_TRUE(learnt.predicts_by(now));
}

TEST(RegisteredSource, NewGenerationVoidsWhatWaitsAndKeepsWhatIsConstant) {
  Learnt learnt;
  learnt.source.give(learnt.walk.picture(learnt.next));
  ASSERT_TRUE(learnt.are_offered());
  learnt.source.begin_generation();
  EXPECT_FALSE(learnt.registered.take());
  EXPECT_TRUE(learnt.predicts_by(Pose())) << "nothing of this generation is known";
  EXPECT_FALSE(learnt.registered.registered_camera());
  learnt.source.give(learnt.walk.picture(60));
  const auto frame = take_soon(learnt.registered);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->index, 60U);
  EXPECT_EQ(frame->generation, 1U);
  EXPECT_LT(glm::distance(frame->frame.state.world_from_camera.translation, true_pose(60).translation), 0.02);
  EXPECT_LT(angle_between(frame->frame.state.world_from_camera, true_pose(60)), 0.01) << "of 0.03 that the record is";
  EXPECT_TRUE(learnt.predicts_by(learnt.correction_of(*frame)));
  const SourceStatus status = learnt.registered.status();
  EXPECT_EQ(status.used, static_cast<std::size_t>(learnt.next) + 1);
  EXPECT_EQ(status.pictures_in, status.used + status.overwritten);
}

TEST(RegisteredSource, HistoryIsCorrectedAndKeepsNothingWaiting) {
  Learnt learnt;
  learnt.source.begin_generation();
  learnt.source.give(learnt.walk.picture(90));
  const auto newest = take_soon(learnt.registered);
  ASSERT_TRUE(newest);
  const Pose correction = learnt.correction_of(*newest);
  for (int i = 89; i > 85; --i) learnt.source.give(learnt.walk.picture(i, true));
  ASSERT_TRUE(learnt.are_offered());
  EXPECT_EQ(learnt.source.own_status().history, 1U) << "the others wait where they are";
  learnt.source.give(learnt.walk.picture(91));
  ASSERT_TRUE(learnt.are_offered());
  const auto next = learnt.registered.take();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->index, 91U) << "before history that waited already";
  const Pose newer = learnt.correction_of(*next);
  EXPECT_LT(
      angle_between(newer * newest->frame.state.world_from_camera, correction * newest->frame.state.world_from_camera),
      0.01);
  for (std::size_t i = 89; i > 85; --i) {
    const auto frame = take_soon(learnt.registered);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    EXPECT_TRUE(frame->is_history);
    EXPECT_LT(angle_between(frame->frame.state.world_from_camera, true_pose(static_cast<int>(i))), 0.01);
    EXPECT_TRUE(learnt.predicts_by(newer));
  }
  const SourceStatus status = learnt.registered.status();
  EXPECT_EQ(status.history, 4U);
  EXPECT_EQ(status.pictures_in, status.used + status.overwritten);
}

IncomingFrame blank(int number, std::size_t camera = 0, cv::Size size = {64, 48}) {
  IncomingFrame incoming;
  incoming.frame.picture = cv::Mat(size, CV_8UC3, cv::Scalar(number % 256, 80, 90));
  incoming.frame.camera = small_camera();
  incoming.frame.camera.width = size.width;
  incoming.frame.camera.height = size.height;
  incoming.frame.state = {stamp_of(number), Pose(), {Pose()}};
  incoming.camera = camera;
  incoming.index = static_cast<std::size_t>(number);
  return incoming;
}

TEST(RegisteredSource, CountsWhatTheReaderTook) {
  for (const int every : {1, 7}) {
    ScriptedSource source(2);
    RegisteredSource registered(source, Walk::get().model(), 1);
    std::array<std::size_t, 2> taken{};
    std::array<std::optional<std::size_t>, 2> last;
    const auto take = [&] {
      const auto frame = registered.take();
      if (!frame) return;
      ++taken[frame->camera];
      EXPECT_TRUE(!last[frame->camera] || *last[frame->camera] < frame->index);
      last[frame->camera] = frame->index;
    };
    constexpr int kPictures = 300;
    for (int i = 0; i < kPictures; ++i) {
      source.give(blank(i, static_cast<std::size_t>(i % 3 == 0 ? 0 : 1)));
      // A reader that asks all the time, and one that takes one picture in seven.
      if (every == 1) {
        ASSERT_TRUE(comes_true([&] {
          take();
          return registered.status().used == static_cast<std::size_t>(i) + 1;
        }));
      } else if (i % every == 0) {
        take();
      }
      const SourceStatus status = registered.status();
      ASSERT_LE(status.used + status.overwritten, status.pictures_in);
      ASSERT_EQ(status.used, taken[0] + taken[1]);
    }
    const auto is_balanced = [&] {
      take();
      const SourceStatus status = registered.status();
      return status.used + status.overwritten == status.pictures_in;
    };
    ASSERT_TRUE(comes_true(is_balanced));
    const SourceStatus status = registered.status();
    EXPECT_EQ(status.pictures_in, 300U);
    EXPECT_EQ(status.used, taken[0] + taken[1]);
    EXPECT_TRUE(every == 1 ? status.used == 300 : status.overwritten > 100) << status.used;
    EXPECT_EQ(last[1], 299U) << "the newest in any case";
    ASSERT_EQ(status.cameras.size(), 2U);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_EQ(status.cameras[c].used, taken[c]);
      EXPECT_EQ(status.cameras[c].in, status.cameras[c].used + status.cameras[c].overwritten);
    }
    EXPECT_FALSE(status.is_decoding);
    EXPECT_EQ(status.bytes_decoded, 0U);
  }
}

TEST(RegisteredSource, CamerasTakeTurnsAndLearnByThemselves) {
  const Walk& walk = Walk::get();
  ScriptedSource source(2);
  RegisteredSource registered(source, walk.model(), 1);
  for (int i = 0; i < Walk::kUncorrected + 8; ++i) {
    source.give(walk.picture(i));
    IncomingFrame other = blank(i, 1);
    source.give(other);
    const auto first = take_soon(registered), second = take_soon(registered);
    ASSERT_TRUE(first && second);
    ASSERT_NE(first->camera, second->camera);
    const IncomingFrame& blank_one = first->camera == 1 ? *first : *second;
    EXPECT_EQ(blank_one.frame.state.world_from_camera, Pose());
  }
  // Who was served goes behind the other, even with newer pictures.
  const int next = Walk::kUncorrected + 8;
  for (const int camera : {0, 1}) source.give(camera == 0 ? walk.picture(next) : blank(next, 1));
  const auto first = take_soon(registered);
  ASSERT_TRUE(first);
  source.give(first->camera == 0 ? walk.picture(next + 1) : blank(next + 1, 1));
  ASSERT_TRUE(comes_true([&] { return source.own_status().used == 2U * next + 3; }));
  const std::size_t asked = source.asked_in_vain();
  ASSERT_TRUE(comes_true([&] { return source.asked_in_vain() > asked + 1; }));
  const auto second = registered.take();
  ASSERT_TRUE(second);
  EXPECT_NE(second->camera, first->camera);
  EXPECT_FALSE(registered.registration().is_correcting) << "of the operator's camera, which sees nothing";
  EXPECT_EQ(registered.predicted_state(stamp_of(5))->world_from_camera,
            source.predicted_state(stamp_of(5))->world_from_camera);
  const IncomingFrame& seeing = first->camera == 0 ? *first : *second;
  EXPECT_NE(seeing.frame.state.world_from_camera, walk.picture(next).frame.state.world_from_camera);
}

TEST(RegisteredSource, NothingWaitsForAPictureThatIsNotThere) {
  ScriptedSource source;
  std::unique_lock gate(source.gate());
  RegisteredSource registered(source, Walk::get().model(), 0);
  ASSERT_TRUE(comes_true([&] { return source.is_at_gate(); }));
  auto asking = std::async(std::launch::async, [&] {
    static_cast<void>(registered.take());
    static_cast<void>(registered.predicted_state(stamp_of(0)));
    static_cast<void>(registered.registered_camera());
    static_cast<void>(registered.registration());
    static_cast<void>(registered.status());
  });
  EXPECT_EQ(asking.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  gate.unlock();
}

/// Full of corners: it takes long.
IncomingFrame great_picture(int number) {
  IncomingFrame incoming = blank(number, 0, {2000, 1500});
  cv::theRNG().state = static_cast<std::uint64_t>(number) + 1;
  cv::randu(incoming.frame.picture, cv::Scalar::all(0), cv::Scalar::all(255));
  return incoming;
}

TEST(RegisteredSource, NothingWaitsForACorrection) {
  ScriptedSource source;
  RegisteredSource registered(source, Walk::get().model(), 0);
  source.give(great_picture(0));
  ASSERT_TRUE(comes_true([&] { return source.own_status().used == 1; }));
  std::size_t asked = 0;
  const std::size_t before = source.asked_in_vain();
  // Until it has done with it: it learns from the picture also after it was offered.
  ASSERT_TRUE(comes_true([&] {
    for (int i = 0; i < 20; ++i) {
      static_cast<void>(registered.take());
      static_cast<void>(registered.predicted_state(stamp_of(0)));
      static_cast<void>(registered.status());
      ++asked;
    }
    return source.asked_in_vain() > before;
  }));
  EXPECT_GT(asked, 100U) << "asked again and again meanwhile";
}

TEST(RegisteredSource, EndsWhileItIsAtWork) {
  const IncomingFrame great = great_picture(0);
  for (int i = 0; i < 6; ++i) {
    ScriptedSource source;
    RegisteredSource registered(source, Walk::get().model(), 0);
    source.give(great);
    if (i % 2 == 0) static_cast<void>(comes_true([&] { return source.own_status().used == 1; }));
    if (i % 3 == 0) static_cast<void>(take_soon(registered));
  }
}

TEST(RegisteredSource, PicturesThatAreNoneStayAsTheyAre) {
  ScriptedSource source;
  RegisteredSource registered(source, Walk::get().model(), 0);
  IncomingFrame broken = blank(0);
  broken.frame.picture = cv::Mat();
  source.give(broken);
  const auto frame = take_soon(registered);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.state.world_from_camera, Pose());
  source.give(blank(1));
  EXPECT_TRUE(take_soon(registered)) << "and it goes on";
}

TEST(RegisteredSource, PlaysARecordingWithItsHistory) {
  const test::PlayedRecording recorded(10);
  const Recording recording = recorded.open();
  const PolygonModel model = test::one_triangle();
  test::SimulatedTime time;
  PlaybackClock clock({.first = test::PlayedRecording::stamp(0), .last = test::PlayedRecording::stamp(9)},
                      time.source());
  RecordingPlayer::Options options;
  options.link.delay = test::milliseconds(100);
  options.history = 3;
  RecordingPlayer player(recording, model, clock, options);
  RegisteredSource registered(player, model, 0);
  time.advance(test::milliseconds(201));
  ASSERT_TRUE(is_picture(take_soon(registered), 1));
  clock.seek(test::PlayedRecording::stamp(7) + test::milliseconds(50));
  for (int i = 6; i >= 3; --i) {
    const auto frame = take_soon(registered);
    ASSERT_TRUE(is_picture(frame, i));
    EXPECT_EQ(frame->generation, 1U);
    EXPECT_EQ(frame->is_history, i < 6);
  }
  EXPECT_FALSE(registered.status().ended);
  time.advance(test::milliseconds(400));
  ASSERT_TRUE(comes_true([&] { return player.status().ended; }));
  EXPECT_FALSE(registered.status().ended) << "its last picture waits";
  std::optional<IncomingFrame> last;
  ASSERT_TRUE(comes_true([&] {
    if (auto frame = registered.take()) last = std::move(frame);
    return registered.status().ended;
  }));
  EXPECT_TRUE(is_picture(last, 7)) << "the last one known before the end";
  const SourceStatus status = registered.status();
  EXPECT_EQ(status.history, 3U);
  EXPECT_EQ(status.pictures_in, status.used + status.overwritten);
}

}  // namespace
}  // namespace foreview
