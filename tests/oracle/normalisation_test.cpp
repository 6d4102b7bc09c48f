#include "oracle/normalisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "oracle/polygon_extraction.h"
#include "oracle/test_scenes.h"

namespace foreview::oracle {
namespace {

TEST(TextureSize, IsTheNextPowerOfTwoUpToTheMaximum) {
  // Eq. 4.28-4.29.
  EXPECT_EQ(texture_size({0.5, 0.2}, 500, 256), glm::ivec2(256, 128));
  EXPECT_EQ(texture_size({0.2, 0.5}, 500, 512), glm::ivec2(128, 256));
  EXPECT_EQ(texture_size({3.0, 0.001}, 500, 256), glm::ivec2(256, 1));
  EXPECT_EQ(texture_size({0.0021, 0.0041}, 500, 256), glm::ivec2(2, 4));
  EXPECT_EQ(texture_size({0.1, 0.1}, 10000, 512), glm::ivec2(512, 512));
  EXPECT_EQ(texture_size({1, 1}, 500, 100), glm::ivec2(100, 100));
}

TEST(TextureSize, RoundingDoesNotDoubleIt) {
  EXPECT_EQ(texture_size({0.256 * (1 + 1e-12), 0.512 * (1 - 1e-12)}, 500, 256), glm::ivec2(128, 256));
  EXPECT_EQ(texture_size({0.256 * (1 + 1e-5), 1e-9}, 500, 256), glm::ivec2(256, 1));
}

/// A picture whose blue and green are linear in a surface's own coordinates, so that any true resampling of it is
/// known.
cv::Mat picture_of(const CameraModel& camera, const std::function<cv::Vec3b(const glm::dvec3& ray)>& colour) {
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      picture.at<cv::Vec3b>(y, x) = colour(camera.ray_from_pixel({x + 0.5, y + 0.5}));
    }
  }
  return picture;
}

TEST(Normalisation, GivesEveryTexelTheColourOfItsPointOfThePlane) {
  const CameraModel camera = pinhole(200, 160, 200);
  // A slanted wall: z = 3 + x / 2. The ray (a, b, 1) meets it at z = 3 / (1 - a / 2).
  const PolygonModel model = model_of({{{-1, -1, 2.5}, {-1, 1, 2.5}, {1, 1, 3.5}, {1, -1, 3.5}}});
  CameraFrame frame;
  frame.camera = camera;
  frame.state = at_origin(model);
  frame.picture = picture_of(camera, [](const glm::dvec3& ray) {
    const double z = 3 / (1 - ray.x / 2);
    return cv::Vec3b(cv::saturate_cast<unsigned char>(128 + 100 * ray.x * z),
                     cv::saturate_cast<unsigned char>(128 + 100 * ray.y * z), 50);
  });
  Options options;
  options.texels_per_metre = 30;
  const PolygonExtraction extraction(model, options);
  const PreparedFrame prepared = extraction.prepare(frame);
  const PolygonResult result = extraction.inspect(prepared, 0);
  const PolygonFrame plane = polygon_frame(model, 0);
  const int w = result.fused.width(), h = result.fused.height();
  ASSERT_EQ(w * h, 64 * 128) << "2.24 m x 2 m at 30 texels per metre";
  for (int j = 0; j < h; ++j) {
    for (int i = 0; i < w; ++i) {
      const glm::dvec3 p = plane.part_from_plane(glm::dvec2((i + 0.5) / w, (j + 0.5) / h) * plane.extent);
      // Beyond the wall lies nothing, so a texel whose four pixels reach there is not valid.
      const double inside = result.projected.signed_distance(camera.pixel_from_camera(p));
      if (inside > 2) {
        EXPECT_EQ(result.fused.valid.at(i, j), 1) << i << ", " << j;
      }
      if (inside < 0.2) {
        EXPECT_EQ(result.fused.valid.at(i, j), 0) << i << ", " << j;
      }
      EXPECT_NEAR(result.filled.at(i, j).x, 128 + 100 * p.x, inside > 2 ? 1.0 : 9.0) << i << ", " << j;
      EXPECT_NEAR(result.filled.at(i, j).y, 128 + 100 * p.y, inside > 2 ? 1.0 : 9.0) << i << ", " << j;
    }
  }
}

TEST(Normalisation, IsValidOnlyWhereAllFourPixelsAre) {
  // One texel a pixel: the wall's texel (i, j) has its centre on a pixel's corner, so it needs four pixels.
  const CameraModel camera = pinhole(64, 64, 64);
  const PolygonModel model =
      model_of({facing_rectangle(-0.25 - 0.5 / 64, -0.25 - 0.5 / 64, 0.25 - 0.5 / 64, 0.25 - 0.5 / 64, 1)});
  const PolygonFrame plane = polygon_frame(model, 0);
  const CaptureState state = at_origin(model);
  const ProjectedPolygon projected = project(model, 0, camera, state, 0.02);
  const Box box = projected.grown_box;
  Mask mask;
  mask.alpha = AlphaImage(box.width(), box.height(), 1.0);
  mask.alpha.at(30 - box.left, 33 - box.top) = 0;
  mask.alpha.at(40 - box.left, 20 - box.top) = kOutside;
  mask.low = mask.high = mask.alpha;
  const UndistortedPicture picture = undistort(cv::Mat(64, 64, CV_8UC3, cv::Scalar(1, 2, 3)), camera);
  const NormalisedTexture texture = normalise(model, 0, plane, {32, 32}, projected, mask, picture, state, 0.02);
  int invalid = 0;
  for (const unsigned char v : texture.texture.valid.values) invalid += v == 0 ? 1 : 0;
  EXPECT_EQ(invalid, 8) << "two dead pixels, each a tap of four texels";
  for (int j = 0; j < 32; ++j) {
    for (int i = 0; i < 32; ++i) {
      const glm::dvec2 pixel =
          camera.pixel_from_camera(plane.part_from_plane(glm::dvec2((i + 0.5) / 32, (j + 0.5) / 32) * plane.extent));
      const auto touches = [&](double x, double y) {
        return std::abs(pixel.x - (x + 0.5)) < 1 && std::abs(pixel.y - (y + 0.5)) < 1;
      };
      EXPECT_EQ(texture.texture.valid.at(i, j), touches(30, 33) || touches(40, 20) ? 0 : 1) << i << ", " << j;
    }
  }
}

TEST(Normalisation, AveragesCellsWhereThePictureIsFinerThanTheTexture) {
  const CameraModel camera = pinhole(128, 128, 128);
  const PolygonModel model = model_of({facing_rectangle(-0.25, -0.25, 0.25, 0.25, 1)});  // 64 x 64 pixels
  CameraFrame frame;
  frame.camera = camera;
  frame.state = at_origin(model);
  // A checkerboard of single pixels: one sample a texel would be 0 or 255 or a mean of few, sixteen make it grey.
  frame.picture = cv::Mat(128, 128, CV_8UC3);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      const auto v = static_cast<unsigned char>((x / 2 + y / 2) % 2 == 0 ? 255 : 0);
      frame.picture.at<cv::Vec3b>(y, x) = {v, v, v};
    }
  }
  Options options;
  options.texels_per_metre = 32;  // 16 x 16 texels of 4 x 4 pixels
  const PolygonExtraction extraction(model, options);
  const PreparedFrame prepared = extraction.prepare(frame);
  const PolygonResult result = extraction.inspect(prepared, 0);
  ASSERT_EQ(result.fused.width(), 16);
  for (int j = 1; j < 15; ++j) {
    for (int i = 1; i < 15; ++i) EXPECT_NEAR(result.fused.colour.at(i, j).x, 127.5, 1e-6);
  }
}

TEST(PolygonExtraction, FusesByStampAndFillsTheRest) {
  const CameraModel camera = pinhole(64, 64, 64);
  // A chip hides the middle of a wall; in the second picture it has moved away.
  const PolygonModel model =
      model_of({facing_rectangle(-0.25, -0.25, 0.25, 0.25, 1), facing_rectangle(-0.05, -0.05, 0.05, 0.05, 0.5)}, {0, 1},
               {"wall", "chip"});
  CameraFrame first;
  first.camera = camera;
  first.state = at_origin(model);
  first.state.stamp = Timestamp{1000};
  first.picture = cv::Mat(64, 64, CV_8UC3, cv::Scalar(10, 20, 30));
  CameraFrame second = first;
  second.state.stamp = Timestamp{2000};
  second.state.world_from_part[1].translation = {5, 0, 0};
  second.picture = cv::Mat(64, 64, CV_8UC3, cv::Scalar(40, 50, 60));

  Options options;
  options.texels_per_metre = 64;
  options.passes = 1;
  PolygonExtraction extraction(model, options);
  const PreparedFrame with_chip = extraction.prepare(first), without = extraction.prepare(second);
  const PolygonResult covered = extraction.inspect(with_chip, 0);
  EXPECT_EQ(covered.fused.valid.at(16, 16), 0);
  EXPECT_EQ(covered.fused.valid.at(2, 16), 1);
  EXPECT_NEAR(covered.filled.at(16, 16).x, 10, 1e-9);
  EXPECT_EQ(extraction.extract(with_chip), 2u);

  PolygonExtraction late(model, options);
  EXPECT_EQ(extraction.extract(without), 1u);
  EXPECT_EQ(extraction.texture(0).colour.at(2, 16), glm::dvec3(40, 50, 60)) << "the newest wins";
  EXPECT_EQ(extraction.texture(0).valid.at(16, 16), 1);

  late.extract(without);
  late.extract(with_chip);
  EXPECT_EQ(late.texture(0).colour.at(2, 16), glm::dvec3(40, 50, 60)) << "also where it came first";
}

}  // namespace
}  // namespace foreview::oracle
