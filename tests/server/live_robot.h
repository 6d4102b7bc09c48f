#pragma once
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <utility>

#include "foreview/server/camera_info.h"
#include "foreview/server/live_source.h"
#include "played_recording.h"

namespace foreview::test {

/// All that waits has been decoded or dropped.
inline bool settled(LiveSource& source) {
  return comes_true([&] { return !source.status().is_decoding; });
}

/// A robot with one camera, 32x24, whose messages go straight into a LiveSource. Picture i is all of grey i, taken at
/// x = i, 100 ms after the one before.
struct LiveRobot {
  static constexpr Duration kPeriod{100'000'000};

  explicit LiveRobot(LiveSource::Options options = {}, bool has_pose_topic = false)
      : source(with_camera(std::move(options), has_pose_topic)) {}

  static LiveSource::Options with_camera(LiveSource::Options options, bool has_pose_topic) {
    options.cameras = {{"eye", "", has_pose_topic}};
    options.parts = {"room", "arm"};
    return options;
  }
  [[nodiscard]] static Timestamp stamp(int i) { return {1'000'000'000'000 + i * kPeriod.nanoseconds}; }
  [[nodiscard]] Reception reception() const {
    const Timestamp now = steady_now();
    return {now, now + Duration{1'700'000'000'000'000'000}, publisher};
  }

  void send_info() {
    CameraModel camera;
    camera.width = size.width;
    camera.height = size.height;
    camera.focal_length = {30, 30};
    camera.principal_point = {size.width / 2.0, size.height / 2.0};
    source.on_camera_info(0, info_from_camera(camera));
  }
  void send_picture(int i, const std::function<void(CompressedImageMessage&)>& change = {}) {
    CompressedImageMessage message{{stamp(i), "optical"}, "jpeg", {}};
    cv::imencode(".jpg", cv::Mat(size, CV_8UC3, cv::Scalar::all(i % 256)), message.data);
    if (change) change(message);
    source.on_picture(0, std::move(message), reception());
  }
  void send_pose(int i) {
    source.on_transforms({{{{stamp(i), "world"}, "optical", Pose{{1, 0, 0, 0}, {1.0 * i, 0, 0}}}}}, false);
  }
  void send_part(int i, double y) {
    source.on_transforms({{{{stamp(i), "world"}, "arm", Pose{{1, 0, 0, 0}, {0, y, 0}}}}}, false);
  }
  [[nodiscard]] static testing::AssertionResult is_picture(const std::optional<IncomingFrame>& frame, int i) {
    if (!frame) return testing::AssertionFailure() << "no frame";
    const CaptureState& state = frame->frame.state;
    if (state.stamp != stamp(i)) return testing::AssertionFailure() << "stamp " << state.stamp.to_string();
    if (std::abs(state.world_from_camera.translation.x - i) > 1e-9) return testing::AssertionFailure() << "pose";
    if (frame->frame.picture.at<cv::Vec3b>(0, 0)[0] != i % 256) return testing::AssertionFailure() << "pixels";
    return testing::AssertionSuccess();
  }

  cv::Size size{32, 24};
  std::uint64_t publisher = 1;
  LiveSource source;
};

}  // namespace foreview::test
