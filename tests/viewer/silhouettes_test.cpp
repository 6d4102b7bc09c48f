#include "foreview/viewer/silhouettes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

namespace foreview {
namespace {

constexpr int kWidth = 96, kHeight = 72;

/// A depth map of planes in inverse depth: `owner` says who is seen at a pixel's centre.
SurfaceMap surface_of(const std::vector<glm::dvec3>& planes, const std::function<int(double, double)>& owner) {
  SurfaceMap map{cv::Mat(kHeight, kWidth, CV_32S), cv::Mat(kHeight, kWidth, CV_32F)};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int polygon = owner(x + 0.5, y + 0.5);
      map.polygon.at<int>(y, x) = polygon;
      map.inverse_z.at<float>(y, x) = polygon < 0
                                          ? 0.0F
                                          : static_cast<float>(glm::dot(planes[static_cast<std::size_t>(polygon)],
                                                                        glm::dvec3(x + 0.5, y + 0.5, 1.0)));
    }
  }
  return map;
}

bool marked(const cv::Mat& mask, int x, int y) {
  return mask.at<std::uint8_t>(y, x) != 0;
}

TEST(Silhouettes, SquareInFrontOfAWall) {
  const std::vector<glm::dvec3> planes{{0, 0, 1.0}, {0, 0, 0.5}};
  const SurfaceMap map =
      surface_of(planes, [](double x, double y) { return x > 30 && x < 50 && y > 25 && y < 45 ? 0 : 1; });
  const cv::Mat mask = beyond_contours(map, planes);
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // The contour as points midway between the outermost pixel pairs: 30.5 ... 49.5 on each side.
      const double u = x + 0.5, v = y + 0.5;
      double nearest = 1e9;
      for (double s = 0.5; s < 20; s += 1) {
        nearest = std::min({nearest, std::hypot(u - 30 - s, v - 25), std::hypot(u - 30 - s, v - 45),
                            std::hypot(u - 30, v - 25 - s), std::hypot(u - 50, v - 25 - s)});
      }
      const bool inside = u > 30 && u < 50 && v > 25 && v < 45;
      EXPECT_EQ(marked(mask, x, y), !inside && nearest <= 12) << x << ' ' << y;
      count += marked(mask, x, y) ? 1 : 0;
    }
  }
  EXPECT_NEAR(count, 4 * 20 * 12 + 3.14159 * 144, 60);
}

TEST(Silhouettes, NothingBehindCountsAsBehind) {
  const std::vector<glm::dvec3> planes{{0, 0, 1.0}};
  const cv::Mat mask = beyond_contours(surface_of(planes, [](double x, double) { return x < 40 ? 0 : -1; }), planes);
  EXPECT_FALSE(marked(mask, 39, 30));
  EXPECT_TRUE(marked(mask, 40, 30));
  EXPECT_TRUE(marked(mask, 51, 30));
  EXPECT_FALSE(marked(mask, 52, 30));
}

TEST(Silhouettes, SlantedPlaneCutIntoPolygonsHasNone) {
  const std::vector<glm::dvec3> planes(4, glm::dvec3(0.02, 0.005, 0.1));
  const SurfaceMap map =
      surface_of(planes, [](double x, double y) { return (x > 40 ? 1 : 0) + (y + 0.3 * x > 50 ? 2 : 0); });
  EXPECT_EQ(cv::countNonZero(beyond_contours(map, planes)), 0);
}

TEST(Silhouettes, RidgesAndCreasesHaveNoneHoweverSteep) {
  // Two planes that meet at x = 40.2: nearest plane wins (a crease seen from inside) or farthest wins (a ridge).
  for (const double slope : {0.01, 0.1, 1.0}) {
    const std::vector<glm::dvec3> planes{{slope, 0, 1 - slope * 40.2}, {-0.3 * slope, 0, 1 + 0.3 * slope * 40.2}};
    const auto side = [](double x) { return x < 40.2 ? 0 : 1; };
    EXPECT_EQ(cv::countNonZero(beyond_contours(surface_of(planes, [&](double x, double) { return side(x); }), planes)),
              0)
        << slope;
    EXPECT_EQ(
        cv::countNonZero(beyond_contours(surface_of(planes, [&](double x, double) { return 1 - side(x); }), planes)), 0)
        << slope;
  }
}

TEST(Silhouettes, SlantedOccluderDoesNotHideBehindItsOwnRim) {
  // A table top that recedes to the left; its right edge is nearest. Its own farther parts are no background.
  const std::vector<glm::dvec3> planes{{0.02, 0, 0.1}, {0, 0, 0.05}};
  const cv::Mat mask = beyond_contours(surface_of(planes, [](double x, double) { return x < 40 ? 0 : 1; }), planes);
  for (int x = 0; x < 40; ++x) EXPECT_FALSE(marked(mask, x, 30)) << x;
  for (int x = 40; x < 52; ++x) EXPECT_TRUE(marked(mask, x, 30)) << x;
}

TEST(Silhouettes, DoesNotReachAcrossAnotherContour) {
  // An occluder, a gap of five pixels to the wall behind, then a post as near as the occluder.
  const std::vector<glm::dvec3> planes{{0, 0, 1.0}, {0, 0, 0.5}, {0, 0, 0.9}};
  const auto owner = [](double x, double) { return x < 40 ? 0 : x < 45 ? 1 : x < 60 ? 2 : 1; };
  const cv::Mat mask = beyond_contours(surface_of(planes, owner), planes);
  for (int x = 40; x < 45; ++x) EXPECT_TRUE(marked(mask, x, 30)) << x;
  for (int x = 45; x < 60; ++x) EXPECT_FALSE(marked(mask, x, 30)) << x;
  for (int x = 60; x < 72; ++x) EXPECT_TRUE(marked(mask, x, 30)) << x;
}

/// A board, 0.4 m wide and high, in part 1, and a wall behind it in part 0; the camera at the origin looks along z.
PolygonModel board_and_wall() {
  RawMesh mesh;
  mesh.vertices = {{-3, -3, 2},     {-3, 3, 2},     {3, 3, 2},     {3, -3, 2},
                   {-0.2, -0.2, 0}, {-0.2, 0.2, 0}, {0.2, 0.2, 0}, {0.2, -0.2, 0}};
  mesh.faces = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  mesh.face_part = {0, 1};
  mesh.part_names = {"wall", "board"};
  ImportOptions options;
  options.backdrop = false;
  options.max_merged_extent = 100;
  return build_polygon_model(mesh, options);
}

SurfaceMap surface_seen(const PolygonModel& model, const CameraModel& camera, const Pose& world_from_camera,
                        const std::vector<Pose>& world_from_part) {
  const auto planes = inverse_depth_planes(model, camera, world_from_camera, world_from_part);
  const Pose board_from_camera = world_from_part[1].inverse() * world_from_camera;
  return surface_of(planes, [&](double u, double v) {
    const glm::dvec3 origin = board_from_camera.translation;
    const glm::dvec3 ray = board_from_camera.rotate(camera.ray_from_pixel({u, v}));
    const glm::dvec3 hit = origin - ray * (origin.z / ray.z);
    const bool on_board = std::abs(hit.x) <= 0.2 && std::abs(hit.y) <= 0.2;
    const std::size_t part = on_board ? 1 : 0;
    for (std::size_t i = 0; i < model.polygons().size(); ++i) {
      if (model.polygons()[i].part == part) return static_cast<int>(i);
    }
    return -1;
  });
}

TEST(Silhouettes, ArePlacedWhereTheUsedPictureSawThemThoughPartsMoved) {
  const PolygonModel model = board_and_wall();
  ASSERT_EQ(model.polygons().size(), 2U);
  CameraModel camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.focal_length = {80, 80};
  camera.principal_point = {48, 36};
  CaptureState used_state;
  used_state.world_from_part = {Pose{}, Pose{glm::dquat(1, 0, 0, 0), {0, 0, 1}}};
  PredictedState state;
  // The board has gone up and away, the wall has slid to the lower right, the camera has moved and turned a little.
  const glm::dvec3 slide(0.15, 0.1, 0);
  state.world_from_part = {Pose{glm::dquat(1, 0, 0, 0), slide}, Pose{glm::dquat(1, 0, 0, 0), {0.05, -0.35, 1.2}}};
  state.world_from_camera = {glm::angleAxis(-0.05, glm::dvec3(0, 1, 0)), {0.2, 0.02, 0}};
  const SurfaceMap used = surface_seen(model, camera, used_state.world_from_camera, used_state.world_from_part);
  const SurfaceMap now = surface_seen(model, camera, state.world_from_camera, state.world_from_part);
  const cv::Mat mask = pixels_beyond_silhouettes(model, camera, state, now, camera, used_state, used);
  int on_mask = 0, wall_hidden_then = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto polygon = static_cast<std::size_t>(now.polygon.at<int>(y, x));
      if (model.polygons()[polygon].part == 1) {
        EXPECT_FALSE(marked(mask, x, y)) << "the board is in front of everything";
        continue;
      }
      // Where the wall's point was in the used picture, whose camera stood at the origin: the board's square there is
      // 32 pixels wide, 32..64 and 20..52.
      const glm::dvec3 ray = state.world_from_camera.rotate(camera.ray_from_pixel({x + 0.5, y + 0.5}));
      const glm::dvec3 eye = state.world_from_camera.translation;
      const glm::dvec2 pixel = camera.pixel_from_camera(eye + ray * ((2 - eye.z) / ray.z) - slide);
      const double beyond_x = std::abs(pixel.x - 48) - 16, beyond_y = std::abs(pixel.y - 36) - 16;
      const double away = beyond_x > 0 && beyond_y > 0 ? std::hypot(beyond_x, beyond_y) : std::max(beyond_x, beyond_y);
      if (away < -1) {
        EXPECT_FALSE(marked(mask, x, y)) << "hidden behind the board then: " << x << ' ' << y;
        ++wall_hidden_then;
      }
      const bool in_picture = pixel.x > 0 && pixel.y > 0 && pixel.x < kWidth && pixel.y < kHeight;
      if (!in_picture) {
        EXPECT_FALSE(marked(mask, x, y)) << x << ' ' << y;
      } else if (away > 1 && away < 11) {
        EXPECT_TRUE(marked(mask, x, y)) << x << ' ' << y;
        ++on_mask;
      } else if (away > 13) {
        EXPECT_FALSE(marked(mask, x, y)) << x << ' ' << y;
      }
    }
  }
  EXPECT_GT(on_mask, 500);
  EXPECT_GT(wall_hidden_then, 200);
}

}  // namespace
}  // namespace foreview
