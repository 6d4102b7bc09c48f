#include "foreview/viewer/view_geometry.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace foreview {
namespace {

CameraModel camera() {
  CameraModel result;
  result.width = 640;
  result.height = 480;
  result.focal_length = {500, 510};
  result.principal_point = {310, 250};
  return result;
}

TEST(FitCamera, SameSizeChangesNothing) {
  const CameraModel fitted = fit_camera(camera(), 640, 480);
  EXPECT_EQ(fitted.focal_length, camera().focal_length);
  EXPECT_EQ(fitted.principal_point, camera().principal_point);
}

TEST(FitCamera, ScalesToTheHeight) {
  const CameraModel fitted = fit_camera(camera(), 320, 240);
  const glm::dvec3 point(0.3, -0.2, 2);
  const glm::dvec2 expected = 0.5 * camera().pixel_from_camera(point);
  EXPECT_LT(glm::distance(fitted.pixel_from_camera(point), expected), 1e-9);
}

TEST(FitCamera, CentresInAWiderViewport) {
  const CameraModel fitted = fit_camera(camera(), 1000, 480);
  EXPECT_EQ(fitted.width, 1000);
  EXPECT_EQ(fitted.principal_point, glm::dvec2(310 + 180, 250));
  EXPECT_EQ(fitted.focal_length, camera().focal_length);
}

TEST(FitCamera, DropsDistortion) {
  CameraModel distorted = camera();
  distorted.distortion_model = DistortionModel::plumb_bob;
  distorted.distortion[0] = -0.2;
  EXPECT_FALSE(fit_camera(distorted, 640, 480).is_distorted());
}

/// Two squares side by side, merged to one polygon each, and the far box around them.
PolygonModel two_squares(bool backdrop) {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 5, 2}};
  ImportOptions options;
  options.merge_coplanar = false;
  options.backdrop = backdrop;
  return build_polygon_model(mesh, options);
}

TEST(ViewGeometry, DrawsSharedEdgesOnceAndNoDiagonals) {
  const PolygonModel model = two_squares(false);
  const ViewGeometry geometry(model, lay_out_charts(model, {}));
  EXPECT_EQ(geometry.triangles.size(), 4 * 3U);
  EXPECT_EQ(geometry.edges.size(), 7 * 2U);
  EXPECT_EQ(geometry.charts.size(), 2U);
}

TEST(ViewGeometry, LeavesTheBackdropsEdgesOut) {
  const PolygonModel model = two_squares(true);
  ASSERT_GT(model.polygons().size(), 2U);
  const ViewGeometry geometry(model, lay_out_charts(model, {}));
  EXPECT_EQ(geometry.edges.size(), 7 * 2U);
  EXPECT_GT(geometry.triangles.size(), 4 * 3U);
}

TEST(ViewGeometry, TexelsLieInsideTheirChart) {
  const PolygonModel model = two_squares(false);
  ChartOptions options;
  options.texels_per_metre = 100;
  const ViewGeometry geometry(model, lay_out_charts(model, options));
  for (const ViewGeometry::Vertex& vertex : geometry.vertices) {
    const ViewGeometry::ChartRecord& chart = geometry.charts[vertex.polygon];
    EXPECT_GE(vertex.texel.x, kChartGutter - 1e-3F);
    EXPECT_GE(vertex.texel.y, kChartGutter - 1e-3F);
    EXPECT_LE(vertex.texel.x, chart.valid.x - kChartGutter + 1e-3F);
    EXPECT_LE(vertex.texel.y, chart.valid.y - kChartGutter + 1e-3F);
    EXPECT_LE(chart.valid.x, chart.size.x);
    EXPECT_LE(chart.valid.y, chart.size.y);
  }
}

}  // namespace
}  // namespace foreview
