#include "foreview/viewer/polygon_report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "foreview/gpu/texture_sets.h"

namespace foreview {
namespace {

/// A triangle and a square beside each other in one plane, cut apart; 100 texels/m.
PolygonModel two_polygons() {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.5, 0}, {0, 0.5, 0}, {1, 0, 0}};
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 2}};
  mesh.part_names = {"table"};
  mesh.face_part = {0, 0};
  ImportOptions options;
  options.merge_coplanar = false;
  options.backdrop = false;
  return build_polygon_model(mesh, options);
}

ChartLayout layout_of(const PolygonModel& model, bool group) {
  ChartOptions options;
  options.texels_per_metre = 100;
  options.group_polygons = group;
  return lay_out_charts(model, options);
}

TEST(PolygonReport, TellsWhatModelAndLayoutKnow) {
  const PolygonModel model = two_polygons();
  const ChartLayout layout = layout_of(model, true);
  const PolygonReport report = describe_polygon(model, layout, 1);
  EXPECT_EQ(report.polygon, 1U);
  EXPECT_EQ(report.part, "table");
  EXPECT_EQ(report.corners, 3U);
  EXPECT_NEAR(report.area, 0.125, 1e-9);
  EXPECT_EQ(report.group, layout.charts[1].group);
  EXPECT_EQ(report.group_polygons, 2U);
  EXPECT_EQ(report.size, layout.charts[1].size);
  EXPECT_NEAR(report.texels_per_metre.x, 100, 1e-9);
}

TEST(PolygonReport, CountsThePolygonsOwnTexels) {
  const PolygonModel model = two_polygons();
  for (const bool group : {false, true}) {
    const ChartLayout layout = layout_of(model, group);
    for (const std::uint32_t polygon : {0U, 1U}) {
      PolygonReport report = describe_polygon(model, layout, polygon);
      const TexelBox box = texel_box(model, layout, polygon);
      const glm::ivec2 first_block = box.first / kChartAlignment;
      const glm::ivec2 blocks = (box.first + box.size - 1) / kChartAlignment - first_block + 1;
      cv::Mat texels(box.size.y, box.size.x, CV_8UC4, cv::Scalar(1, 2, 3, 255));
      const cv::Mat times(blocks.y, blocks.x, CV_32S, cv::Scalar(kNeverCaptured));
      count_texels(report, model, layout, texels, times, {});
      const double expected = report.area * 100 * 100;
      EXPECT_NEAR(static_cast<double>(report.texels), expected, 0.05 * expected);
      EXPECT_EQ(report.observed_share, 1);
      EXPECT_TRUE(report.captures.empty());
      // The left half of the box unseen: half of the square.
      texels(cv::Rect(0, 0, box.size.x / 2, box.size.y)).setTo(cv::Scalar(1, 2, 3, 0));
      count_texels(report, model, layout, texels, times, {});
      if (polygon == 0) {
        EXPECT_NEAR(report.observed_share, 0.5, 0.03);
      } else {
        EXPECT_GT(report.observed_share, 0.1);
        EXPECT_LT(report.observed_share, 0.9);
      }
      texels.setTo(cv::Scalar::all(0));
      count_texels(report, model, layout, texels, times, {});
      EXPECT_EQ(report.observed_share, 0);
    }
  }
}

TEST(PolygonReport, CapturesNewestFirst) {
  const PolygonModel model = two_polygons();
  const ChartLayout layout = layout_of(model, false);
  PolygonReport report = describe_polygon(model, layout, 0);
  const TexelBox box = texel_box(model, layout, 0);
  const glm::ivec2 blocks = (box.first + box.size - 1) / kChartAlignment - box.first / kChartAlignment + 1;
  ASSERT_GE(blocks.x, 3);
  cv::Mat times(blocks.y, blocks.x, CV_32S, cv::Scalar(1500));
  times.col(0).setTo(cv::Scalar(2500));
  times.col(1).setTo(cv::Scalar(kNeverCaptured));
  const cv::Mat texels(box.size.y, box.size.x, CV_8UC4, cv::Scalar::all(255));
  const Timestamp epoch{5'000'000'000};
  count_texels(report, model, layout, texels, times, epoch);
  ASSERT_EQ(report.captures.size(), 2U);
  EXPECT_EQ(report.captures[0].stamp, Timestamp{7'500'000'000});
  EXPECT_EQ(report.captures[1].stamp, Timestamp{6'500'000'000});
  EXPECT_NEAR(report.captures[0].share, 1.0 / blocks.x, 1e-9);
  EXPECT_NEAR(report.captures[1].share, (blocks.x - 2.0) / blocks.x, 1e-9);
  // Never more than can be shown.
  for (int i = 0; i < blocks.x * blocks.y; ++i) times.at<int>(i / blocks.x, i % blocks.x) = i;
  count_texels(report, model, layout, texels, times, epoch);
  EXPECT_EQ(report.captures.size(), PolygonReport::kMostCaptures);
  EXPECT_EQ(report.captures[0].stamp, epoch + Duration{(blocks.x * blocks.y - 1) * 1'000'000LL});
}

}  // namespace
}  // namespace foreview
