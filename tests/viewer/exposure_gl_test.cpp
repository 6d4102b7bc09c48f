// Rule 5 of BatchedExtraction, as the operator sees it: pictures of different exposure, one predicted view.
#include <array>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "foreview/gpu/batched/batched_extraction.h"
#include "foreview/gpu/exposure.h"
#include "foreview/viewer/predicted_view.h"
#include "gpu/gl_test_fixture.h"
#include "viewer/painted_scene.h"

namespace foreview {
namespace {

using test::facing_rectangle;
using test::pinhole;
using Gain = std::array<double, 3>;  // red, green, blue

constexpr double kDepth = 2;  // metres
constexpr Gain kAsItIs{1, 1, 1};

/// 0..1, smooth enough that no filter changes it by more than a few parts of 255.
Gain wall(double x, double y) {
  return {0.42 + 0.2 * std::sin(2.1 * x + y), 0.4 + 0.2 * std::cos(1.7 * x - 2 * y), 0.45 + 0.2 * std::sin(2.5 * y)};
}

/// A camera that looks at a wall of 3.2 x 2 m of 32 polygons.
class ExposureTest : public GlTest {
 protected:
  ExposureTest() : camera_(pinhole(120, 80, 110)) {
    ImportOptions import;
    import.merge_coplanar = false;
    import.backdrop = false;
    model_ = build_polygon_model(facing_rectangle(3.2, 2, kDepth, 8, 4), import);
    charts_.texels_per_metre = 100;
    charts_.page_size = 1024;
  }

  struct Extraction {
    TextureStore store;
    BatchedExtraction pipeline;
    Extraction(const ExposureTest& test, bool compensate, Publishing publishing = Publishing::direct)
        : store(test.model_, lay_out_charts(test.model_, test.charts_), publishing),
          pipeline(store, options(compensate)) {}
    static ExtractionOptions options(bool compensate) {
      ExtractionOptions result;
      result.compensate_exposure = compensate;
      return result;
    }
  };

  [[nodiscard]] static Pose world_from_camera(double x) { return {{1, 0, 0, 0}, {x, 0, 0}}; }

  /// What a camera at (x, 0, 0) sees of the wall at an exposure. `repainted` gives the wall's colour anew.
  template <class Colour>
  [[nodiscard]] cv::Mat picture(double x, const Gain& gain, const Colour& colour) const {
    cv::Mat result(camera_.height, camera_.width, CV_8UC3);
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const glm::dvec2 ray = (glm::dvec2(u + 0.5, v + 0.5) - camera_.principal_point) / camera_.focal_length;
        const Gain c = colour(x + kDepth * ray.x, kDepth * ray.y);
        for (std::size_t i = 0; i < 3; ++i) {
          const float shown = exposed(static_cast<float>(c[i]), static_cast<float>(gain[i]));
          result.at<cv::Vec3b>(v, u)[static_cast<int>(2 - i)] = cv::saturate_cast<std::uint8_t>(255 * shown);
        }
      }
    }
    return result;
  }
  [[nodiscard]] cv::Mat picture(double x, const Gain& gain) const { return picture(x, gain, wall); }

  [[nodiscard]] CameraFrame frame(double seconds, double x, const cv::Mat& picture) const {
    CameraFrame result;
    result.camera = camera_;
    result.picture = picture;
    result.state.stamp = Timestamp::from_seconds(seconds);
    result.state.world_from_camera = world_from_camera(x);
    result.state.world_from_part.resize(model_.parts().size());
    return result;
  }

  [[nodiscard]] PredictedState seen_from(double x) const {
    return {{}, world_from_camera(x), std::vector<Pose>(model_.parts().size())};
  }

  static constexpr int kPictures = 9;
  /// From the wall's left to its right, ever more red and darker green, without an overlap of the first and the last.
  static double place(int i) { return -0.5 + 0.125 * i; }
  static Gain gain(int i) { return {std::pow(1.045, i), std::pow(0.97, i), 1 + 0.1 * std::sin(i)}; }
  void extract_all(Extraction& extraction) const {
    for (int i = 0; i < kPictures; ++i) {
      extraction.pipeline.extract(frame(i + 1, place(i), picture(place(i), gain(i))));
    }
  }

  struct Difference {
    double mean = 0, greatest = 0;  // 1/255
  };
  [[nodiscard]] static Difference difference(const cv::Mat& a, const cv::Mat& b) {
    cv::Mat apart;
    cv::absdiff(a, b, apart);
    const cv::Scalar mean = cv::mean(apart);
    return {(mean[0] + mean[1] + mean[2]) / 3, cv::norm(a, b, cv::NORM_INF)};
  }
  /// Of the view of what only the first picture has shown (the left edge of it) from what the last one would show.
  [[nodiscard]] Difference old_region_difference(const Extraction& extraction) const {
    PredictedView view(extraction.store);
    const cv::Rect left(0, 0, 30, camera_.height);
    return difference(view.render(camera_, seen_from(place(0)))(left), picture(place(0), gain(kPictures - 1))(left));
  }

  CameraModel camera_;
  PolygonModel model_;
  ChartOptions charts_;
};

TEST(Exposure, IsAGroupThatKeepsBlackAndWhite) {
  for (const float gain : {0.4F, 0.9F, 1.0F, 1.3F, 2.5F}) {
    EXPECT_EQ(exposed(0, gain), 0);
    EXPECT_NEAR(exposed(1, gain), 1, 1e-6);
    EXPECT_NEAR(exposed(0.01F, gain), 0.01F * gain, 1e-6);
    for (const float colour : {0.05F, 0.3F, 0.7F, 0.95F}) {
      EXPECT_EQ(exposed(colour, 1), colour);
      EXPECT_NEAR(exposed(exposed(colour, gain), 1 / gain), colour, 1e-5);
      EXPECT_NEAR(exposed(exposed(colour, gain), 1.2F), exposed(colour, 1.2F * gain), 1e-5);
    }
  }
}

TEST_F(ExposureTest, OldRegionsTakeTheNewestPicturesExposure) {
  Extraction compensated(*this, true), plain(*this, false);
  extract_all(compensated);
  extract_all(plain);
  const Gain wanted = gain(kPictures - 1);
  const Exposure found = compensated.store.read_exposure();
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found.shown[i] / wanted[i], 1, 0.02) << "channel " << i;
  const Difference apart = old_region_difference(compensated);
  EXPECT_LT(apart.mean, 1.5);
  EXPECT_LE(apart.greatest, 8);
  // Where the newest picture looked, its own colours appear.
  PredictedView view(compensated.store);
  const double last = place(kPictures - 1);
  EXPECT_LT(difference(view.render(camera_, seen_from(last)), picture(last, wanted)).mean, 1);
  // Without it the same place is far off, and no gain appears.
  EXPECT_GT(old_region_difference(plain).mean, 8);
  const Exposure off = plain.store.read_exposure();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(off.shown[i], 1);
    EXPECT_EQ(off.inverse[i], 1);
  }
}

TEST_F(ExposureTest, SamePicturesGiveTheSameTexturesAsWithoutIt) {
  Extraction compensated(*this, true), plain(*this, false);
  for (Extraction* extraction : {&compensated, &plain}) {
    for (int i = 0; i < 4; ++i) extraction->pipeline.extract(frame(i + 1, 0, picture(0, kAsItIs)));
  }
  EXPECT_LE(cv::norm(compensated.store.read_pages()[0], plain.store.read_pages()[0], cv::NORM_INF), 1);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(compensated.store.read_exposure().shown[i], 1, 0.003);
}

TEST_F(ExposureTest, WhatChangesItsColourDoesNotTiltTheRest) {
  Extraction extraction(*this, true);
  for (int i = 0; i < 3; ++i) extraction.pipeline.extract(frame(i + 1, 0, picture(0, kAsItIs)));
  // A quarter of the picture turns redder by a quarter, which a change of exposure could do too.
  const auto repainted = [](double x, double y) {
    Gain colour = wall(x, y);
    if (x > 0.55) colour[0] *= 1.25;
    return colour;
  };
  for (int i = 3; i < 6; ++i) {
    extraction.pipeline.extract(frame(i + 1, 0, picture(0, kAsItIs, repainted)));
    for (std::size_t channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(extraction.store.read_exposure().shown[channel], 1, 0.015) << "picture " << i;
    }
  }
}

TEST_F(ExposureTest, ALatePictureFillsWithoutChangingWhatIsShown) {
  Extraction extraction(*this, true);
  for (int i = 0; i < 4; ++i) extraction.pipeline.extract(frame(i + 10, 0.3, picture(0.3, gain(i))));
  const Exposure before = extraction.store.read_exposure();
  extraction.pipeline.extract(frame(5, -0.3, picture(-0.3, {0.85, 0.85, 0.85})));
  const Exposure after = extraction.store.read_exposure();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(after.shown[i], before.shown[i]);
    EXPECT_NEAR(after.inverse[i], 1 / 0.85, 0.03);
  }
  // What only the late picture has shown appears as the newest would have shown it.
  PredictedView view(extraction.store);
  const cv::Rect left(0, 0, 25, camera_.height);
  EXPECT_LT(difference(view.render(camera_, seen_from(-0.3))(left), picture(-0.3, gain(3))(left)).mean, 2);
}

TEST_F(ExposureTest, PublishingChangesNothing) {
  Extraction direct(*this, true), buffered(*this, true, Publishing::buffered);
  extract_all(direct);
  extract_all(buffered);
  glFinish();
  const Exposure a = direct.store.read_exposure(), b = buffered.store.read_exposure();
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(a.shown[i], b.shown[i]);
  EXPECT_EQ(cv::norm(direct.store.read_pages()[0], buffered.store.read_pages()[0], cv::NORM_INF), 0);
  PredictedView direct_view(direct.store), buffered_view(buffered.store);
  EXPECT_EQ(
      cv::norm(direct_view.render(camera_, seen_from(0)), buffered_view.render(camera_, seen_from(0)), cv::NORM_INF),
      0);
  buffered.pipeline.clear();
  for (const float gain : {buffered.store.read_exposure().shown[0], buffered.store.read_exposure().inverse[0]}) {
    EXPECT_EQ(gain, 1);
  }
}

TEST_F(ExposureTest, SavedTexturesLookTheSameWhenLoaded) {
  Extraction extraction(*this, true), other(*this, true);
  extract_all(extraction);
  ASSERT_GT(std::abs(extraction.store.read_exposure().shown[0] - 1), 0.2);
  const std::filesystem::path directory = std::filesystem::path(::testing::TempDir()) / "foreview-exposure-textures";
  std::filesystem::remove_all(directory);
  save_textures(extraction.store, directory);
  load_textures(other.store, directory);
  other.pipeline.adopt_store();
  std::filesystem::remove_all(directory);
  EXPECT_EQ(other.store.read_exposure().shown[0], 1);
  PredictedView before(extraction.store), after(other.store);
  const Difference apart = difference(before.render(camera_, seen_from(-0.2)), after.render(camera_, seen_from(-0.2)));
  EXPECT_LE(apart.greatest, 2);
  // And go on being compared with.
  other.pipeline.extract(frame(100, 0, picture(0, {1.3, 0.9, 1.15})));
  const Gain last = gain(kPictures - 1), next{1.3, 0.9, 1.15};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(other.store.read_exposure().shown[i], next[i] / last[i], 0.02);
}

}  // namespace
}  // namespace foreview
