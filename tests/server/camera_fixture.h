#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/server/capture/v4l2_camera.h"
#include "server/simulated_camera.h"

namespace foreview {

constexpr Duration ms(std::int64_t count) {
  return {count * 1'000'000};
}
constexpr Duration seconds(std::int64_t count) {
  return {count * 1'000'000'000};
}

/// The real camera code on a simulated device. At the end: V4L2's rules were kept, nothing is left open or mapped, and
/// every picture that the driver filled was delivered or counted.
class SimulatedCameraTest : public testing::Test {
 protected:
  void TearDown() override {
    close_camera();
    EXPECT_EQ(device.open_files, 0u);
    EXPECT_EQ(device.mappings, 0u);
    for (const std::string& violation : device.violations) ADD_FAILURE() << violation;
  }

  V4l2Camera& camera() {
    if (!camera_) camera_ = std::make_unique<V4l2Camera>(options, device);
    return *camera_;
  }
  void close_camera() {
    if (camera_) check_counts();
    camera_.reset();
    device.filled = device.discarded = 0;
  }

  /// Pictures of so much simulated time.
  std::vector<CapturedPicture> capture(Duration time) {
    std::vector<CapturedPicture> pictures;
    V4l2Camera& source = camera();
    const Timestamp end = device.monotonic() + time;
    while (device.monotonic() < end) {
      if (auto picture = source.next(end - device.monotonic())) pictures.push_back(std::move(*picture));
    }
    return pictures;
  }

  /// The one line with which opening, or capturing for a while, ends; empty: it does not.
  std::string error_of_capture(Duration time = seconds(1)) {
    try {
      capture(time);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      EXPECT_EQ(std::string(error.what()).find("/dev/video0: "), 0u) << error.what();
      return error.what();
    }
    return "";
  }

  void check_counts() {
    const V4l2Camera::Statistics& s = camera_->statistics();
    std::size_t waiting = device.filled - device.discarded;
    waiting -= s.delivered + s.overtaken + s.flagged + s.short_frames + s.wrong_size + s.damaged + s.bad_stamps;
    EXPECT_LE(waiting, device.buffers()) << "pictures neither delivered nor counted";
  }

  SimulatedCamera device;
  V4l2Camera::Options options;
  std::unique_ptr<V4l2Camera> camera_;
};

}  // namespace foreview
