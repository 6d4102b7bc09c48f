#include <gtest/gtest.h>

#include <filesystem>

#include "foreview/recordings/recording.h"
#include "foreview/viewer/picture_metrics.h"
#include "foreview/viewer/rotation_warp.h"

namespace foreview {
namespace {

struct Means {
  double delayed_psnr = 0, delayed_ssim = 0, rotation_psnr = 0, rotation_ssim = 0;
};

/// Over pictures 200, 215 ... 590 against those `back` pictures before.
Means means_over_kitchen(const Recording& recording, std::size_t back) {
  const Recording::Camera& camera = recording.cameras()[0];
  Means means;
  int instants = 0;
  for (std::size_t i = 200; i <= 590; i += 15, ++instants) {
    const auto now = camera.world_from_camera.at(camera.pictures[i].stamp);
    const auto before = camera.world_from_camera.at(camera.pictures[i - back].stamp);
    const cv::Mat truth = recording.read_picture(0, i), delayed = recording.read_picture(0, i - back);
    const cv::Mat rotation =
        warp_by_rotation(delayed, camera.model.undistorted(), before.value(), camera.model.undistorted(), now.value());
    means.delayed_psnr += pixel_error(delayed, truth).psnr().value();
    means.delayed_ssim += structural_similarity(delayed, truth).value();
    means.rotation_psnr += pixel_error(rotation, truth).psnr().value();
    means.rotation_ssim += structural_similarity(rotation, truth).value();
  }
  means.delayed_psnr /= instants;
  means.delayed_ssim /= instants;
  means.rotation_psnr /= instants;
  means.rotation_ssim /= instants;
  return means;
}

// An independent program measured these figures with the picture exactly 15 before. `foreview evaluate --delay 500ms`
// shows the one 16 before, because at 30 Hz that is the newest captured *before* t - 0.5 s; --delay 499ms shows the
// picture of the reference.
TEST(KitchenReference, DelayedPictureAndRotationOnlyWarp) {
  const std::filesystem::path directory = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::is_directory(directory)) GTEST_SKIP() << directory << " is not there";
  const Recording recording = Recording::open(directory);
  const Timestamp t = recording.cameras()[0].pictures[200].stamp;
  EXPECT_EQ(recording.newest_before(0, t - Duration::from_seconds(0.5)), 184U);
  EXPECT_EQ(recording.newest_before(0, t - Duration::from_seconds(0.499)), 185U);

  const Means means = means_over_kitchen(recording, 15);
  EXPECT_NEAR(means.delayed_psnr, 13.07, 0.01);
  EXPECT_NEAR(means.delayed_ssim, 0.502, 0.001);
  EXPECT_NEAR(means.rotation_psnr, 14.58, 0.01);
  EXPECT_NEAR(means.rotation_ssim, 0.544, 0.001);
}

}  // namespace
}  // namespace foreview
