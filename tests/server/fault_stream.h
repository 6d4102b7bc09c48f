#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "child_process.h"
#include "dds_test_domain.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"
#include "played_recording.h"

namespace foreview::test {

inline constexpr const char* kFaultTopic = "/eye/image_raw/compressed";

/// What the robots' processes tell the test's.
struct RobotCounts {
  std::atomic<int> pictures{0};  ///< sent
  std::atomic<int> garbage{0};
  std::atomic<std::int64_t> garbage_bytes{0}, garbage_nanoseconds{0};
  std::atomic<bool> ended{false};
};

/// A robot with one camera that speaks over DDS; to live in a process of its own. Picture i of run r is all of grey
/// i + 40 r, taken at (i, r, 0).
class FaultRobot {
 public:
  FaultRobot(int domain, RobotCounts& counts) : counts_(&counts), node_({domain}) {
    pictures_ = node_.advertise<CompressedImageMessage>(kFaultTopic, QosProfile::sensor_data);
    infos_ = node_.advertise<CameraInfoMessage>("/eye/camera_info", QosProfile::sensor_data);
    transforms_ = node_.advertise<TransformMessage>("/tf", QosProfile::transforms);
    const bool heard = comes_true(
        [&] { return pictures_->subscribers() > 0 && infos_->subscribers() > 0 && transforms_->subscribers() > 0; });
    if (!heard) _exit(1);
    // A reader is known here a little before it knows of us.
    wait(200);
  }

  static void wait(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }
  [[nodiscard]] static Timestamp now() {
    return {std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
                .count()};
  }
  [[nodiscard]] static int grey(int index, int run) { return (index + 40 * run) % 256; }

  void send_state(Timestamp stamp, int index, int run = 0) {
    CameraModel camera;
    camera.width = size.width;
    camera.height = size.height;
    camera.focal_length = {30, 30};
    camera.principal_point = {size.width / 2.0, size.height / 2.0};
    CameraInfoMessage info = info_from_camera(camera);
    info.header = {stamp, "optical"};
    infos_->write(info);
    transforms_->write({{{{stamp, "world"}, "optical", Pose{{1, 0, 0, 0}, {1.0 * index, 1.0 * run, 0}}}}});
  }
  void send(Timestamp stamp, int index, int run = 0, const std::function<void(CompressedImageMessage&)>& change = {}) {
    send_state(stamp, index, run);
    CompressedImageMessage message{{stamp, "optical"}, "jpeg", {}};
    cv::imencode(".jpg", cv::Mat(size, CV_8UC3, cv::Scalar::all(grey(index, run))), message.data);
    if (change) change(message);
    pictures_->write(message);
    ++counts_->pictures;
  }

  cv::Size size{64, 48};

 private:
  RobotCounts* counts_;
  DdsNode node_;
  std::unique_ptr<DdsWriter<CompressedImageMessage>> pictures_;
  std::unique_ptr<DdsWriter<CameraInfoMessage>> infos_;
  std::unique_ptr<DdsWriter<TransformMessage>> transforms_;
};

inline std::int64_t resident_kib() {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with("VmRSS:")) return std::stoll(line.substr(6));
  }
  return 0;
}

/// What a display does with a stream, without drawing: asks all it needs to know for a frame, as often as it can.
class Watcher {
 public:
  explicit Watcher(int domain, LiveSource::Options options = {})
      : node({domain}), source(with_camera(std::move(options))), receiver(node, {camera_topics(kFaultTopic)}, source) {}

  static LiveSource::Options with_camera(LiveSource::Options options) {
    options.cameras = {{"eye", "", false}};
    return options;
  }

  /// One frame's questions. Every picture must be the one that its pose and stamp say.
  void ask() {
    const Timestamp begun = steady_now();
    while (auto frame = source.take()) {
      const auto& state = frame->frame.state;
      const int index = static_cast<int>(std::lround(state.world_from_camera.translation.x));
      const int run = static_cast<int>(std::lround(state.world_from_camera.translation.y));
      const double found = frame->frame.picture.at<cv::Vec3b>(0, 0)[0];
      if (std::abs(found - FaultRobot::grey(index, run)) > 3) ++wrong_states;
      seen.push_back({index, run, state.stamp, frame->generation, frame->frame.picture.size(), begun});
    }
    const SourceStatus status = source.status();
    const Timestamp now = source.time_at(begun);
    static_cast<void>(source.predicted_state(now));
    const Duration took = steady_now() - begun;
    waits.push_back(took);
    if (status.newest_capture) staleness = std::max(staleness, status.now - *status.newest_capture);
  }
  template <class Condition>
  bool ask_until(const Condition& condition) {
    return comes_true([&] {
      ask();
      return condition();
    });
  }
  void ask_for(Duration time) {
    const Timestamp end = steady_now() + time;
    while (steady_now() < end) {
      ask();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  /// The robot has ended, and nothing is under way any more.
  void ask_to_the_end(const RobotCounts& counts) {
    EXPECT_TRUE(ask_until([&] { return counts.ended.load(); }));
    ask_for(milliseconds(500));
    EXPECT_TRUE(ask_until([&] { return !source.status().is_decoding; }));
    ask();
  }

  /// All that was sent is used or counted.
  void expect_sums(int sent) {
    const SourceStatus status = source.status();
    EXPECT_EQ(status.pictures_in, status.used + status.overwritten + status.damaged + status.stateless);
    EXPECT_EQ(static_cast<int>(status.pictures_in + status.duplicated + status.lost + receiver.lost()), sent);
    EXPECT_EQ(wrong_states, 0);
    EXPECT_EQ(status.used, seen.size());
  }

  void report(int sent) {
    const SourceStatus status = source.status();
    std::sort(waits.begin(), waits.end());
    const auto ms = [](Duration duration) { return static_cast<double>(duration.nanoseconds) * 1e-6; };
    const double p99 = ms(waits[waits.size() * 99 / 100]), longest = ms(waits.back());
    std::printf(
        "sent %d: used %zu, overwritten %zu, damaged %zu, stateless %zu, duplicated %zu, lost on the link %zu, "
        "on the network %zu; generation %zu; oldest shown %.2f s; reader's wait p99 %.3f ms, longest %.2f ms\n",
        sent, status.used, status.overwritten, status.damaged, status.stateless, status.duplicated, status.lost,
        receiver.lost(), static_cast<std::size_t>(status.generation), staleness.seconds(), p99, longest);
    const auto record = [](const char* name, std::size_t value) {
      testing::Test::RecordProperty(name, static_cast<int>(value));
    };
    record("sent", static_cast<std::size_t>(sent));
    record("used", status.used);
    record("overwritten", status.overwritten);
    record("damaged", status.damaged);
    record("stateless", status.stateless);
    record("duplicated", status.duplicated);
    record("lost", status.lost + receiver.lost());
    testing::Test::RecordProperty("reader_wait_p99_us", static_cast<int>(p99 * 1000));
    // The display never stops: far from what it takes, near to what a wait for a picture would be.
    EXPECT_LT(longest, 1000);
  }

  struct Seen {
    int index, run;
    Timestamp stamp;
    std::uint64_t generation;
    cv::Size size;
    Timestamp at;  ///< steady
  };
  DdsNode node;
  LiveSource source;
  LiveReceiver receiver;
  std::vector<Seen> seen;
  std::vector<Duration> waits;
  Duration staleness;
  int wrong_states = 0;
};

}  // namespace foreview::test
