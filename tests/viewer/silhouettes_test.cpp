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

}  // namespace
}  // namespace foreview
