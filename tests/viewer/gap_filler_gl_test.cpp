#include "foreview/viewer/gap_filler.h"

#include <array>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "foreview/viewer/render_target.h"
#include "gpu/gl_test_fixture.h"
#include "viewer/painted_scene.h"

namespace foreview {
namespace {

using test::distance;
using test::facing_rectangle;
using test::PaintedScene;
using test::pinhole;
using test::pixel;
using test::Rgb;

constexpr Rgb kRed{200, 30, 20}, kGreen{10, 220, 40}, kBlue{15, 25, 210}, kBlack{0, 0, 0};
constexpr int kWidth = 320, kHeight = 240;  // cracks are up to some 8 pixels wide

ChartOptions charts() {
  ChartOptions options;
  options.texels_per_metre = 50;
  options.page_size = 512;
  options.group_polygons = false;
  return options;
}

CameraModel camera() {
  return pinhole(kWidth, kHeight, 200);
}

/// Rectangles facing the camera, each `width` x 4 m around (x, 0, depth).
struct Upright {
  double x = 0, width = 1, depth = 2;
};
RawMesh uprights(const std::vector<Upright>& places) {
  RawMesh mesh;
  for (const Upright& place : places) {
    const RawMesh one = facing_rectangle(place.width, 4, place.depth);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (glm::dvec3 vertex : one.vertices) {
      vertex.x += place.x;
      mesh.vertices.push_back(vertex);
    }
    for (auto face : one.faces) {
      for (auto& corner : face) corner += first;
      mesh.faces.push_back(face);
    }
  }
  return mesh;
}

class GapFillerTest : public GlTest {
 protected:
  static cv::Mat render(PaintedScene& scene, GapFilling gaps) {
    ViewStyle style;
    style.gaps = gaps;
    return scene.view().render(camera(), scene.seen_from({}), style);
  }
};

// 100 pixels a metre: a crack of 3 pixels in the middle, and an opening of 38 at the right.
TEST_F(GapFillerTest, ACrackGivesWayAndAnOpeningStays) {
  PaintedScene scene(uprights({{-1.015, 2, 2}, {0.615, 1.2, 2}}), charts());
  for (std::size_t i = 0; i < 2; ++i) scene.paint(i, kRed);
  scene.upload();
  const cv::Mat plain = render(scene, GapFilling::none), filled = render(scene, GapFilling::all);
  EXPECT_EQ(pixel(plain, 160, 120), kBlack) << "else there is nothing to fill";
  EXPECT_LE(distance(pixel(filled, 160, 120), kRed), 8);
  EXPECT_LE(distance(pixel(render(scene, GapFilling::cracks), 160, 120), kRed), 8);
  EXPECT_GT(pixel(filled, 158, 120).r, pixel(plain, 158, 120).r + 30) << "half a crack";
  EXPECT_EQ(pixel(filled, 310, 120), kBlack) << "it is wide";
  EXPECT_EQ(pixel(filled, 100, 120), pixel(plain, 100, 120));
}

TEST_F(GapFillerTest, WhatWasNeverSeenTakesTheColoursAroundItWhereTheSurfaceGoesOn) {
  PaintedScene scene(facing_rectangle(4, 4, 2, 5, 1), charts());
  for (std::size_t i = 0; i < 5; ++i) scene.paint(i, i < 2 ? kRed : kGreen);
  scene.set_state(2, kBlue, 0.5F);
  scene.upload();
  const cv::Mat plain = render(scene, GapFilling::none), filled = render(scene, GapFilling::all);
  ASSERT_LE(distance(pixel(plain, 160, 120), kBlue), 1);
  EXPECT_LE(distance(pixel(render(scene, GapFilling::cracks), 160, 120), kBlue), 1) << "it is no crack";
  EXPECT_LE(pixel(filled, 160, 120).b, 60) << "its own colour is a guess from its neighbours' means";
  EXPECT_GT(pixel(filled, 130, 120).r, 150) << "beside the red one";
  EXPECT_GT(pixel(filled, 190, 120).g, 150) << "beside the green one";
  for (const int x : {20, 100, 220, 300}) EXPECT_EQ(pixel(filled, x, 60), pixel(plain, x, 60)) << "known, at " << x;
}

TEST_F(GapFillerTest, WhatWasNeverSeenBesideASilhouetteStays) {
  PaintedScene scene(uprights({{0, 8, 4}, {0.5, 1, 1}}), charts());
  scene.paint(0, kGreen);
  scene.paint(1, kRed);
  scene.set_state(0, kBlue, 0.5F);
  scene.upload();
  const cv::Mat filled = render(scene, GapFilling::all);
  ASSERT_LE(distance(pixel(filled, 165, 120), kRed), 1) << "the one in front begins at 160";
  for (const int x : {20, 100, 150, 156}) EXPECT_LE(distance(pixel(filled, x, 120), kBlue), 2) << x;
}

TEST_F(GapFillerTest, AHoleOfAChartTakesTheColoursAroundIt) {
  PaintedScene scene(facing_rectangle(4, 4, 2), charts());
  scene.paint(0, kRed);
  const Chart& chart = scene.layout().charts[0];
  for (int y = 90; y < 110; ++y) {
    for (int x = 90; x < 110; ++x) scene.set_texel(chart, x, y, kBlue, false);
  }
  scene.upload();
  const glm::dvec2 middle = chart.part_from_texel(glm::dvec2(chart.origin) + 100.0);
  const int x = 160 + static_cast<int>(100 * middle.x), y = 120 + static_cast<int>(100 * middle.y);
  ASSERT_LE(distance(pixel(render(scene, GapFilling::none), x, y), kBlue), 1);
  EXPECT_LE(distance(pixel(render(scene, GapFilling::all), x, y), kRed), 2);
}

TEST_F(GapFillerTest, OverlaysAndFastFramesShowWhatIsKnown) {
  PaintedScene scene(facing_rectangle(4, 4, 2, 5, 1), charts());
  for (std::size_t i = 0; i < 5; ++i) scene.paint(i, kRed);
  scene.set_state(2, kBlue, 0.5F);
  scene.upload();
  const PredictedState state = scene.seen_from({});
  ViewStyle fast, wireframe, age;
  for (ViewStyle* style : {&fast, &wireframe, &age}) style->gaps = GapFilling::all;
  fast.quality = ViewQuality::fast;
  wireframe.wireframe = true;
  age.age = true;
  EXPECT_LE(distance(pixel(scene.view().render(camera(), state, fast), 160, 120), kBlue), 1);
  EXPECT_LE(distance(pixel(scene.view().render(camera(), state, wireframe), 160, 150), kBlue), 1);
  EXPECT_GT(pixel(scene.view().render(camera(), state, age), 160, 120).b, 60);
}

TEST_F(GapFillerTest, StaysInItsViewportAndLeavesAlphaAtOne) {
  PaintedScene scene(facing_rectangle(4, 4, 2, 5, 1), charts());
  for (std::size_t i = 0; i < 5; ++i) scene.paint(i, kRed);
  scene.set_state(2, kBlue, 0.5F);
  scene.upload();
  AntialiasedTarget target;
  target.resize(kWidth, kHeight, "test");
  constexpr std::array<GLfloat, 4> kWhite{1, 1, 1, 1};
  glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, kWhite.data());
  // Two thirds of a viewport that is the framebuffer's middle.
  ViewStyle style;
  style.gaps = GapFilling::all;
  scene.view().draw(camera(), scene.seen_from({}), style, target.framebuffer(), {80, 60, 160, 120, 0, 100}, false);
  cv::Mat picture(kHeight, kWidth, CV_8UC4);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.resolve());
  glReadPixels(0, 0, kWidth, kHeight, GL_BGRA, GL_UNSIGNED_BYTE, picture.data);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  int wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto& at = picture.at<cv::Vec4b>(y, x);
      const bool drawn = x >= 80 && x < 180 && y >= 60 && y < 180;
      const Rgb expected = drawn ? kRed : Rgb(255);
      wrong += at[3] != 255 || distance(Rgb(at[2], at[1], at[0]), expected) > 3 ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST_F(GapFillerTest, WorksAtAnySize) {
  PaintedScene scene(facing_rectangle(4, 4, 2, 5, 1), charts());
  scene.paint(0, kRed);
  scene.upload();
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 7}, {3, 200}, {641, 3}}) {
    const cv::Mat picture = scene.view().render(pinhole(width, height, 10), scene.seen_from({}));
    EXPECT_EQ(picture.size(), cv::Size(width, height));
  }
}

}  // namespace
}  // namespace foreview
