#include "foreview/viewer/predicted_view.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

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

constexpr Rgb kRed{200, 30, 20}, kGreen{10, 220, 40}, kBlue{15, 25, 210}, kPink{255, 105, 181};

ChartOptions density(double texels_per_metre, int max_texels = 256) {
  ChartOptions options;
  options.texels_per_metre = texels_per_metre;
  options.max_texels = max_texels;
  options.page_size = 1024;
  options.group_polygons = false;
  return options;
}

/// Linear in the plane, so that any correct filter gives its value at the footprint's centre.
Rgb gradient(const glm::dvec3& p) {
  return {128 + 100 * p.x, 128 + 100 * p.y, 128 - 60 * p.x + 40 * p.y};
}

Pose turned(const glm::dvec3& eye, const glm::dvec3& target) {
  return looking_at(eye, target, {0, -1, 0});
}

class PredictedViewTest : public GlTest {
 protected:
  /// As the textures are: what is not known stays as it is.
  static ViewStyle as_known() {
    ViewStyle style;
    style.gaps = GapFilling::none;
    return style;
  }
};

/// Where the ray through a pixel meets the plane z = depth of the world.
glm::dvec3 on_plane(const CameraModel& camera, const Pose& world_from_camera, double u, double v, double depth) {
  const glm::dvec3 ray = world_from_camera.rotate(camera.ray_from_pixel({u, v}));
  return world_from_camera.translation + ray * ((depth - world_from_camera.translation.z) / ray.z);
}

struct GradientCase {
  const char* name;
  glm::dvec3 eye;
  double focal_length;
};

class PredictedViewGradient : public PredictedViewTest, public ::testing::WithParamInterface<GradientCase> {};

TEST_P(PredictedViewGradient, EveryPixelShowsTheColourOfItsPoint) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(100));
  scene.paint(0, gradient);
  scene.upload();
  const CameraModel camera = pinhole(96, 64, GetParam().focal_length);
  const Pose pose = turned(GetParam().eye, {0, 0, 2});
  const cv::Mat picture = scene.view().render(camera, scene.seen_from(pose));
  int inside = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      // Only pixels that lie in the rectangle whole: the others are mixed with black.
      bool whole = true;
      for (const glm::dvec2 corner : {glm::dvec2(-1, -1), {2, -1}, {-1, 2}, {2, 2}}) {
        const glm::dvec3 p = on_plane(camera, pose, x + corner.x, y + corner.y, 2);
        whole = whole && std::abs(p.x) < 1 && std::abs(p.y) < 1;
      }
      if (!whole) continue;
      ++inside;
      const Rgb expected = gradient(on_plane(camera, pose, x + 0.5, y + 0.5, 2));
      ASSERT_LE(distance(pixel(picture, x, y), expected), 2) << "at " << x << ", " << y;
    }
  }
  EXPECT_GT(inside, 20);
}

INSTANTIATE_TEST_SUITE_P(
    Cases, PredictedViewGradient,
    ::testing::Values(GradientCase{"magnified", {0, 0, 1.5}, 60}, GradientCase{"one_to_one", {0, 0, 0}, 200},
                      GradientCase{"oblique", {1.5, -0.8, 0.7}, 60}, GradientCase{"grazing", {1.4, 0.2, 1.8}, 60},
                      GradientCase{"level_1", {0, 0, -2}, 200}, GradientCase{"level_3", {0.4, 0, -2}, 50},
                      GradientCase{"level_4", {0, 0, -4}, 40}),
    [](const auto& gradient_case) { return gradient_case.param.name; });

TEST_F(PredictedViewTest, RowZeroIsTheTop) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(50));
  scene.paint(0, [](const glm::dvec3& p) { return p.y < 0 ? kRed : kBlue; });
  scene.upload();
  const cv::Mat picture = scene.view().render(pinhole(60, 60, 60), scene.seen_from({}));
  EXPECT_LE(distance(pixel(picture, 30, 10), kRed), 1);
  EXPECT_LE(distance(pixel(picture, 30, 50), kBlue), 1);
}

TEST_F(PredictedViewTest, FlipTurnsThePictureOver) {
  PaintedScene scene(facing_rectangle(2, 2, 2, 3, 3), density(50));
  for (std::size_t i = 0; i < 9; ++i) scene.paint(i, gradient);
  scene.set_state(4, kGreen, 0);
  scene.upload();
  const CameraModel camera = pinhole(60, 48, 40);
  const PredictedState state = scene.seen_from(turned({0.2, -0.3, -0.5}, {0, 0, 2}));
  AntialiasedTarget target;
  target.resize(60, 48, "test");
  scene.view().draw(camera, state, {}, target.framebuffer(), {0, 0, 60, 48}, false);
  const cv::Mat upright = target.read();
  scene.view().draw(camera, state, {}, target.framebuffer(), {0, 0, 60, 48}, true);
  const cv::Mat flipped = target.read();
  int different = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 60; ++x) different += distance(pixel(upright, x, y), pixel(flipped, x, 47 - y)) > 2 ? 1 : 0;
  }
  // Sample positions are not symmetric: outlines may differ, and nothing else.
  EXPECT_LT(different, 150);
  EXPECT_GT(distance(pixel(upright, 30, 10), pixel(flipped, 30, 10)), 20) << "the scene itself is not symmetric";
}

TEST_F(PredictedViewTest, DrawsIntoItsViewportOnly) {
  PaintedScene scene(facing_rectangle(20, 20, 2), density(10));
  scene.paint(0, kRed);
  scene.upload();
  AntialiasedTarget target;
  target.resize(64, 64, "test");
  constexpr std::array<GLfloat, 4> kWhite{1, 1, 1, 1};
  glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, kWhite.data());
  ViewStyle style;
  style.wireframe = true;
  scene.view().draw(pinhole(32, 32, 16), scene.seen_from({}), style, target.framebuffer(), {8, 16, 40, 20}, false);
  const cv::Mat picture = target.read();
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool in_viewport = x >= 8 && x < 48 && y >= 16 && y < 36;
      ASSERT_LE(distance(pixel(picture, x, y), in_viewport ? kRed : Rgb(255)), 1) << x << ", " << y;
    }
  }
}

// Each chart's block in a colour of its own: without anti-aliasing, every pixel must have exactly its polygon's colour,
// from wherever it is seen, or a filter has mixed two charts.
TEST_F(PredictedViewTest, NoFilterLeavesTheChart) {
  const CameraModel camera = pinhole(80, 60, 100);
  const GlTexture colour = make_texture_2d(GL_RGBA8, 80, 60), depth = make_texture_2d(GL_DEPTH_COMPONENT32F, 80, 60);
  const GlFramebuffer framebuffer = make_framebuffer(colour.id(), depth.id());
  for (const double texels_per_metre : {9.0, 50.0, 133.0}) {
    PaintedScene scene(facing_rectangle(1, 0.7, 2, 5, 4), density(texels_per_metre));
    const auto colour_of = [](int polygon) { return Rgb((polygon * 97) % 256, (polygon * 41) % 256, 255 - polygon); };
    scene.paint_ground({0, 255, 0});
    for (int i = 0; i < 20; ++i) scene.paint(static_cast<std::size_t>(i), colour_of(i));
    scene.upload();
    for (const double back : {-1.9, -1.0, 0.0, 3.0, 8.0, 20.0, 60.0}) {
      for (const double aside : {0.0, 0.5, 3.0, 12.0}) {
        const PredictedState state = scene.seen_from(turned({aside * (2 + back), 0.1, -back}, {0, 0, 2}));
        const auto surface = scene.view().render_surface(camera, state);
        scene.view().draw(camera, state, as_known(), framebuffer.id(), {0, 0, 80, 60}, false);
        cv::Mat picture(60, 80, CV_8UC3);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.id());
        glReadPixels(0, 0, 80, 60, GL_BGR, GL_UNSIGNED_BYTE, picture.data);
        double worst = 0;
        for (int y = 0; y < 60; ++y) {
          for (int x = 0; x < 80; ++x) {
            const int polygon = surface.polygon.at<int>(y, x);
            const Rgb expected = polygon < 0 ? Rgb(0) : colour_of(polygon);
            worst = std::max(worst, distance(pixel(picture, x, y), expected));
          }
        }
        EXPECT_LE(worst, 1) << texels_per_metre << " texels/m, " << back << " m back, " << aside << " aside";
      }
    }
  }
}

TEST_F(PredictedViewTest, MagnifiedNothingBeyondTheGutterIsSampled) {
  PaintedScene scene(facing_rectangle(1, 1, 2), density(9));
  scene.paint(0, kRed);
  const Chart& chart = scene.layout().charts[0];
  ASSERT_LT(chart.inner.x + 2 * kChartGutter, chart.size.x);
  for (int y = 0; y < chart.size.y; ++y) {
    for (int x = 0; x < chart.size.x; ++x) {
      const bool grown_box = x < chart.inner.x + 2 * kChartGutter && y < chart.inner.y + 2 * kChartGutter;
      if (!grown_box) scene.set_texel(chart, x, y, kGreen, true);
    }
  }
  scene.upload();
  const cv::Mat picture = scene.view().render(pinhole(80, 80, 140), scene.seen_from({}));
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 80; ++x) ASSERT_LE(pixel(picture, x, y).g, 31) << x << ", " << y;
  }
}

/// Mask of the pixels that the background does not touch: where an outline runs between two samples of a pixel is up to
/// the last bit of its vertices.
cv::Mat inside(const cv::Mat& picture) {
  cv::Mat touched(picture.size(), CV_8U, cv::Scalar(255));
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const bool in_picture = x + dx >= 0 && x + dx < picture.cols && y + dy >= 0 && y + dy < picture.rows;
          if (in_picture && pixel(picture, x + dx, y + dy) == Rgb(0)) touched.at<std::uint8_t>(y, x) = 0;
        }
      }
    }
  }
  return touched;
}

// Issue: a plane with a gradient, cut into polygons, renders like the same plane uncut.
TEST_F(PredictedViewTest, CutPlaneLooksLikeTheWholeOne) {
  PaintedScene whole(facing_rectangle(2, 2, 2), density(120, 512));
  PaintedScene cut(facing_rectangle(2, 2, 2, 7, 5), density(120, 512));
  whole.paint(0, gradient);
  for (std::size_t i = 0; i < cut.model().polygons().size(); ++i) cut.paint(i, gradient);
  whole.upload();
  cut.upload();
  const CameraModel camera = pinhole(120, 90, 100);
  for (const glm::dvec3 eye :
       {glm::dvec3(0, 0, 1.6), {0.3, 0.2, 0.8}, {0, 0, -1}, {2, 1, 0}, {0, 0, -5}, {1, 0, -9}, {0, 2, -16}}) {
    const cv::Mat a = whole.view().render(camera, whole.seen_from(turned(eye, {0, 0, 2})));
    const cv::Mat b = cut.view().render(camera, cut.seen_from(turned(eye, {0, 0, 2})));
    EXPECT_LE(cv::norm(a, b, cv::NORM_INF, inside(a)), 2) << eye.x << ", " << eye.y << ", " << eye.z;
  }
}

TEST_F(PredictedViewTest, NeverSeenPolygonsHaveTheirStatesColour) {
  PaintedScene scene(facing_rectangle(2, 2, 2, 2, 1), density(50));
  scene.paint(0, kRed);
  scene.paint(1, kRed);
  scene.set_state(1, {12, 120, 60}, 0.5F);
  scene.upload();
  const cv::Mat picture = scene.view().render(pinhole(60, 60, 60), scene.seen_from({}), as_known());
  EXPECT_LE(distance(pixel(picture, 15, 30), kRed), 1);
  EXPECT_LE(distance(pixel(picture, 45, 30), {12, 120, 60}), 1);
}

TEST_F(PredictedViewTest, HolesArePinkOnRequest) {
  PaintedScene scene(facing_rectangle(3, 1, 2, 3, 1), density(16));
  scene.paint(0, kRed);
  scene.paint(1, kBlue, false);
  scene.paint(2, kRed);
  scene.set_state(2, kRed, 0.5F);
  const Chart& chart = scene.layout().charts[0];
  scene.set_texel(chart, kChartGutter + 7, kChartGutter + 7, kBlue, false);
  scene.upload();
  const CameraModel camera = pinhole(96, 32, 64);  // two pixels a texel
  const PredictedState state = scene.seen_from({});
  const cv::Mat plain = scene.view().render(camera, state, as_known());
  EXPECT_LE(distance(pixel(plain, 48, 16), kBlue), 1);
  EXPECT_LE(distance(pixel(plain, 80, 16), kRed), 1);
  ViewStyle style;
  style.holes_pink = true;
  const cv::Mat picture = scene.view().render(camera, state, style);
  EXPECT_LE(distance(pixel(picture, 48, 16), kPink), 1) << "filled texels";
  EXPECT_LE(distance(pixel(picture, 80, 16), kPink), 1) << "never seen polygon";
  int pink = 0;
  for (int y = 1; y < 31; ++y) {
    for (int x = 1; x < 31; ++x) pink += distance(pixel(picture, x, y), kPink) <= 1 ? 1 : 0;
  }
  EXPECT_EQ(pink, 4) << "one texel is two by two pixels";
}

TEST_F(PredictedViewTest, BackFacesAreMuted) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(50));
  scene.paint(0, kRed);
  scene.upload();
  const cv::Mat picture = scene.view().render(pinhole(60, 60, 60), scene.seen_from(turned({0, 0, 4}, {0, 0, 2})));
  const double grey = 0.299 * kRed.r + 0.587 * kRed.g + 0.114 * kRed.b;
  EXPECT_LE(distance(pixel(picture, 30, 30), 0.5 * (kRed + Rgb(grey))), 1);
}

TEST_F(PredictedViewTest, WireframeFollowsPolygonEdges) {
  PaintedScene scene(facing_rectangle(2, 2, 2, 2, 2), density(30));
  for (std::size_t i = 0; i < 4; ++i) scene.paint(i, kBlue);
  scene.upload();
  ViewStyle style;
  style.wireframe = true;
  const cv::Mat picture = scene.view().render(pinhole(81, 81, 60), scene.seen_from({}), style);
  EXPECT_GT(pixel(picture, 40, 25).g, 150) << "on the upright edge in the middle";
  EXPECT_GT(pixel(picture, 25, 40).g, 150) << "on the level one";
  EXPECT_LE(distance(pixel(picture, 25, 25), kBlue), 1) << "on the diagonal, which is no edge of a polygon";
  EXPECT_LE(distance(pixel(picture, 30, 20), kBlue), 1);
}

TEST_F(PredictedViewTest, HiddenEdgesAreLeftOut) {
  RawMesh mesh = facing_rectangle(2, 2, 2);
  const RawMesh behind = facing_rectangle(1, 1, 3);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), behind.vertices.begin(), behind.vertices.end());
  mesh.faces.push_back({first, first + 2, first + 3, first + 1});
  PaintedScene scene(mesh, density(30));
  scene.paint(0, kBlue);
  scene.paint(1, kRed);
  scene.upload();
  ViewStyle style;
  style.wireframe = true;
  const cv::Mat picture = scene.view().render(pinhole(80, 80, 60), scene.seen_from({}), style);
  for (int y = 15; y < 65; ++y) {
    for (int x = 15; x < 65; ++x) ASSERT_LE(distance(pixel(picture, x, y), kBlue), 1) << x << ", " << y;
  }
}

TEST_F(PredictedViewTest, EdgesGoOverThePictureOfACapture) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(30));
  AntialiasedTarget target;
  target.resize(80, 80, "test");
  constexpr std::array<GLfloat, 4> kPicture{0.5F, 0, 0.5F, 1};
  glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, kPicture.data());
  const CaptureState state{{}, {}, {Pose{}}};
  scene.view().draw_edges(pinhole(80, 80, 60.4), state, target.framebuffer(), {0, 0, 80, 80}, false);
  const cv::Mat picture = target.read();
  EXPECT_LE(distance(pixel(picture, 40, 40), {128, 0, 128}), 1);
  EXPECT_LE(distance(pixel(picture, 2, 2), {128, 0, 128}), 1);
  EXPECT_GT(pixel(picture, 9, 40).g, 100) << "the left edge, at x = 9.8";
  EXPECT_GT(pixel(picture, 40, 70).g, 100) << "the lower edge, at y = 70.2";
}

TEST_F(PredictedViewTest, PartsGoWhereTheStatePutsThem) {
  PaintedScene scene(facing_rectangle(0.5, 0.5, 2), density(50));
  scene.paint(0, kRed);
  scene.upload();
  PredictedState state = scene.seen_from({});
  state.world_from_part[0].translation = {0.6, -0.3, 0};
  const cv::Mat picture = scene.view().render(pinhole(80, 60, 60), state);
  EXPECT_LE(distance(pixel(picture, 40 + 18, 30 - 9), kRed), 1);
  EXPECT_LE(distance(pixel(picture, 40, 30), Rgb(0)), 1);
}

TEST_F(PredictedViewTest, StaysSteadyFarFromTheOrigin) {
  constexpr double kFar = 500'000;  // metres, as in a national grid
  RawMesh mesh = facing_rectangle(2, 2, 2, 4, 4);
  for (glm::dvec3& v : mesh.vertices) v += glm::dvec3(kFar, kFar, 0);
  PaintedScene scene(mesh, density(100));
  for (std::size_t i = 0; i < 16; ++i) {
    scene.paint(i, [&](const glm::dvec3& p) { return gradient(p - glm::dvec3(kFar, kFar, 0)); });
  }
  scene.upload();
  PaintedScene near_scene(facing_rectangle(2, 2, 2, 4, 4), density(100));
  for (std::size_t i = 0; i < 16; ++i) near_scene.paint(i, gradient);
  near_scene.upload();
  Pose pose = turned({0.3, 0.2, 0}, {0, 0, 2});
  const CameraModel camera = pinhole(80, 60, 60);
  const cv::Mat expected = near_scene.view().render(camera, near_scene.seen_from(pose));
  pose.translation += glm::dvec3(kFar, kFar, 0);
  const cv::Mat actual = scene.view().render(camera, scene.seen_from(pose));
  EXPECT_LE(cv::norm(expected, actual, cv::NORM_INF), 3);
}

TEST_F(PredictedViewTest, SurfaceTellsPolygonDistanceAndProvenance) {
  PaintedScene scene(facing_rectangle(3, 1, 2, 3, 1), density(16));
  scene.paint(0, kRed);
  scene.paint(1, kBlue, false);
  scene.paint(2, kRed);
  scene.set_state(2, kRed, 0.5F);
  scene.upload();
  const CameraModel camera = pinhole(120, 60, 64);
  const Pose pose = turned({0.1, -0.4, -0.3}, {0, 0, 2});
  const auto surface = scene.view().render_surface(camera, scene.seen_from(pose));
  int on_polygon[3] = {0, 0, 0}, beside = 0;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 120; ++x) {
      const glm::dvec3 p = on_plane(camera, pose, x + 0.5, y + 0.5, 2);
      const bool unsure = std::abs(std::abs(p.x) - 1.5) < 1e-3 || std::abs(std::abs(p.x) - 0.5) < 1e-3 ||
                          std::abs(std::abs(p.y) - 0.5) < 1e-3;
      if (unsure) continue;
      const bool inside = std::abs(p.x) < 1.5 && std::abs(p.y) < 0.5;
      const int expected = inside ? static_cast<int>(std::floor(p.x + 1.5)) : -1;
      ASSERT_EQ(surface.polygon.at<int>(y, x), expected) << x << ", " << y;
      const double z = (pose.inverse() * p).z;
      if (inside) {
        ++on_polygon[expected];
        ASSERT_NEAR(surface.inverse_z.at<float>(y, x), 1 / z, 1e-5 / z);
        ASSERT_EQ(surface.provenance.at<std::uint8_t>(y, x), expected == 0 ? 2 : expected == 1 ? 1 : 0);
      } else {
        ++beside;
        ASSERT_EQ(surface.inverse_z.at<float>(y, x), 0.0F);
        ASSERT_EQ(surface.provenance.at<std::uint8_t>(y, x), 0);
      }
    }
  }
  EXPECT_GT(std::min({on_polygon[0], on_polygon[1], on_polygon[2], beside}), 200);
}

TEST_F(PredictedViewTest, SurfaceOfABackFaceIsNeverSeen) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(16));
  scene.paint(0, kRed);
  scene.upload();
  const CaptureState behind{{}, turned({0, 0, 4}, {0, 0, 2}), {Pose{}}};
  const auto surface = scene.view().render_surface(pinhole(20, 20, 20), behind);
  EXPECT_EQ(surface.polygon.at<int>(10, 10), 0);
  EXPECT_EQ(surface.provenance.at<std::uint8_t>(10, 10), 0);
}

TEST_F(PredictedViewTest, CameraInAPolygonsPlaneAndPolygonsBehindIt) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(50));
  scene.paint(0, kRed);
  scene.upload();
  for (const Pose& pose : {turned({0, 0, 2}, {1, 0, 2}), turned({0, 0, 2}, {0, 0, 3}), turned({0, 0, 1}, {0, 0, 0}),
                           turned({0, 0.999999, 2}, {0, 0, 2.0000001}), turned({0, 0, 1.99}, {0, 0, 3})}) {
    const cv::Mat picture = scene.view().render(pinhole(40, 30, 20), scene.seen_from(pose));
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) ASSERT_LE(pixel(picture, x, y).b, kRed.b + 1);
    }
  }
}

TEST_F(PredictedViewTest, OnePixel) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(50));
  scene.paint(0, kRed);
  scene.upload();
  const cv::Mat picture = scene.view().render(pinhole(1, 1, 1), scene.seen_from({}));
  ASSERT_EQ(picture.size(), cv::Size(1, 1));
  const auto surface = scene.view().render_surface(pinhole(1, 1, 1), scene.seen_from({}));
  EXPECT_EQ(surface.polygon.at<int>(0, 0), 0);
}

TEST_F(PredictedViewTest, TooLargeAPictureIsRefused) {
  PaintedScene scene(facing_rectangle(2, 2, 2), density(50));
  EXPECT_THROW((void)scene.view().render(pinhole(1'000'000, 10, 1), scene.seen_from({})), InputError);
}

}  // namespace
}  // namespace foreview
