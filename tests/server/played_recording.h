#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/server/frame_source.h"
#include "support/temporary_directory.h"

namespace foreview::test {

using std::chrono_literals::operator""ms;

constexpr Duration milliseconds(std::int64_t count) {
  return {count * 1'000'000};
}

/// A clock that stands still until it is told to go on.
class SimulatedTime {
 public:
  [[nodiscard]] Timestamp now() const { return {now_.load()}; }
  void advance(Duration duration) { now_ += duration.nanoseconds; }
  [[nodiscard]] std::function<Timestamp()> source() const {
    return [this] { return now(); };
  }

 private:
  std::atomic<std::int64_t> now_{0};
};

/// Waits for another thread to bring something about; false after half a minute.
template <class Condition>
bool comes_true(const Condition& condition) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > limit) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
}

/// The source's next picture, as soon as it is decoded.
inline std::optional<IncomingFrame> take_soon(FrameSource& source) {
  std::optional<IncomingFrame> frame;
  static_cast<void>(comes_true([&] { return (frame = source.take()).has_value(); }));
  return frame;
}

/// A recording of `cameras` cameras with `count` pictures each, 100 ms apart from kFirst on (the second camera's 50 ms
/// later, and so on); picture i of camera c is all of the colour (i, c, 99), and was taken at x = its seconds.
struct PlayedRecording {
  static constexpr Timestamp kFirst{1'000'000'000'000};
  static constexpr Duration kPeriod{100'000'000};

  explicit PlayedRecording(int count, int cameras = 1) {
    RecordingWriter::Description description;
    description.name = "played";
    for (int c = 0; c < cameras; ++c) {
      CameraModel camera;
      camera.width = 16;
      camera.height = 12;
      camera.focal_length = {20, 20};
      camera.principal_point = {8, 6};
      description.cameras.push_back({cameras == 1 ? "" : "camera" + std::to_string(c), camera});
    }
    RecordingWriter writer(path(), description);
    for (int c = 0; c < cameras; ++c) {
      const auto camera = static_cast<std::size_t>(c);
      for (int i = 0; i < count; ++i) writer.add_picture(camera, stamp(i, c), picture(i, c), "png");
      for (int i = -1; i <= count; ++i) {
        const Timestamp t = stamp(i, c);
        writer.add_camera_pose(camera, t, Pose{{1, 0, 0, 0}, {(t - kFirst).seconds(), 0, 0}});
      }
    }
    writer.finish();
  }
  [[nodiscard]] static Timestamp stamp(int index, int camera = 0) {
    return {kFirst.nanoseconds + index * kPeriod.nanoseconds + camera * kPeriod.nanoseconds / 2};
  }
  [[nodiscard]] static cv::Mat picture(int index, int camera) {
    return {12, 16, CV_8UC3, cv::Scalar(index, camera, 99)};
  }
  [[nodiscard]] std::filesystem::path path() const { return directory / "played"; }
  [[nodiscard]] Recording open() const { return Recording::open(path()); }

  TemporaryDirectory directory;
};

inline PolygonModel one_triangle() {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}};
  return build_polygon_model(mesh, {.backdrop = false});
}

/// Whether the frame is that picture, pixels, stamp and pose.
inline testing::AssertionResult is_picture(const std::optional<IncomingFrame>& frame, int index, int camera = 0) {
  if (!frame) return testing::AssertionFailure() << "no frame";
  if (frame->index != static_cast<std::size_t>(index) || frame->camera != static_cast<std::size_t>(camera)) {
    return testing::AssertionFailure() << "picture " << frame->index << " of camera " << frame->camera;
  }
  const Timestamp stamp = PlayedRecording::stamp(index, camera);
  if (frame->frame.state.stamp != stamp) return testing::AssertionFailure() << "stamp differs";
  if (std::abs(frame->frame.state.world_from_camera.translation.x - (stamp - PlayedRecording::kFirst).seconds()) >
      1e-9) {
    return testing::AssertionFailure() << "pose differs";
  }
  if (cv::norm(frame->frame.picture, PlayedRecording::picture(index, camera), cv::NORM_INF) != 0) {
    return testing::AssertionFailure() << "pixels differ";
  }
  return testing::AssertionSuccess();
}

}  // namespace foreview::test
