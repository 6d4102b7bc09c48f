#include "foreview/scene/polygon_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "foreview/scene/errors.h"
#include "scene/polygon_invariants.h"

namespace foreview {
namespace {

ImportOptions without_backdrop() {
  ImportOptions options;
  options.backdrop = false;
  return options;
}

/// A cube of side 0.4 about the origin, fronts outwards, each side cut into two triangles.
RawMesh triangulated_cube() {
  RawMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back((i & 1) != 0 ? 0.2 : -0.2, (i & 2) != 0 ? 0.2 : -0.2, (i & 4) != 0 ? 0.2 : -0.2);
  mesh.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A flat outline in the plane z = 1.
RawMesh outline(const std::vector<glm::dvec2>& corners) {
  RawMesh mesh;
  mesh.faces.emplace_back();
  for (const glm::dvec2& corner : corners) {
    mesh.faces[0].push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.emplace_back(corner, 1.0);
  }
  return mesh;
}

TEST(BuildPolygonModel, JoinsTheTwoTrianglesOfEachSideOfACube) {
  ImportReport report;
  const PolygonModel model = build_polygon_model(triangulated_cube(), without_backdrop(), &report);
  EXPECT_EQ(model.polygons().size(), 6U);
  EXPECT_EQ(model.vertices().size(), 8U);
  EXPECT_EQ(report.faces_merged, 12U);
  EXPECT_EQ(report.boundary_edges, 0U);
  EXPECT_EQ(report.boundary_loops, 0U);
  EXPECT_EQ(report.edges_with_opposed_winding, 0U);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_NEAR(total_area(model), 6 * 0.16, 1e-12);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(model.neighbours_of(i).size(), 4U);
    EXPECT_NEAR(model.polygons()[i].offset, 0.2, 1e-12) << "fronts look outwards";
  }
  check_invariants(model);
}

TEST(BuildPolygonModel, MergesOnlyWhatTheOptionsAllow) {
  ImportOptions options = without_backdrop();
  options.max_merged_extent = 0.39;
  EXPECT_EQ(build_polygon_model(triangulated_cube(), options).polygons().size(), 12U) << "a side would be too wide";
  options = without_backdrop();
  options.merge_coplanar = false;
  EXPECT_EQ(build_polygon_model(triangulated_cube(), options).polygons().size(), 12U);
}

TEST(BuildPolygonModel, DoesNotMergeAcrossParts) {
  RawMesh mesh = outline({{0, 0}, {0.2, 0}, {0.2, 0.2}, {0, 0.2}});
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.part_names = {"a", "b"};
  mesh.face_part = {0, 1};
  const PolygonModel model = build_polygon_model(mesh, without_backdrop());
  EXPECT_EQ(model.polygons().size(), 2U);
  EXPECT_EQ(model.vertices().size(), 6U) << "parts move apart: they share no vertex";
  EXPECT_EQ(model.part_index("b"), 1);
  EXPECT_EQ(model.part_index("c"), -1);
  mesh.face_part = {0, 0};
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop()).polygons().size(), 1U);
}

TEST(BuildPolygonModel, DoesNotMergeOpposedWinding) {
  RawMesh mesh = outline({{0, 0}, {0.2, 0}, {0.2, 0.2}, {0, 0.2}});
  mesh.faces = {{0, 1, 2}, {0, 3, 2}};
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, without_backdrop(), &report);
  EXPECT_EQ(model.polygons().size(), 2U);
  EXPECT_EQ(report.edges_with_opposed_winding, 1U);
  ASSERT_EQ(model.neighbours_of(0).size(), 1U) << "neighbours even so";
  EXPECT_EQ(model.neighbours_of(0)[0], 1U);
}

TEST(BuildPolygonModel, DoesNotMergeWhereTheResultWouldBeConcaveOrBent) {
  RawMesh mesh = outline({{0, 0}, {0.2, 0}, {0.05, 0.05}, {0, 0.2}});
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop()).polygons().size(), 2U);
  mesh = outline({{0, 0}, {0.2, 0}, {0.2, 0.2}, {0, 0.2}});
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.vertices[3].z += 0.01;
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop()).polygons().size(), 2U);
  // A fold of a tiny mesh is not flat only because it is within the tolerance.
  for (glm::dvec3& vertex : mesh.vertices) vertex *= 0.005;
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop()).polygons().size(), 2U);
}

TEST(BuildPolygonModel, FlatGridBecomesFewLargeConvexPolygonsWithoutLosingArea) {
  RawMesh mesh;
  constexpr int n = 20;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.vertices.emplace_back(0.1 * x, 0.1 * y, 0);
  const auto at = [](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  const PolygonModel model = build_polygon_model(mesh, without_backdrop());
  EXPECT_LE(model.polygons().size(), 60U);
  EXPECT_NEAR(total_area(model), 4.0, 1e-9);
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const PolygonFrame frame = polygon_frame(model, i);
    EXPECT_LE(std::max(frame.extent.x, frame.extent.y), 0.5 + 1e-9);
    EXPECT_FALSE(model.neighbours_of(i).empty());
  }
  check_invariants(model);
}

TEST(BuildPolygonModel, TakesConcaveFacesApart) {
  ImportReport report;
  const PolygonModel l_shape =
      build_polygon_model(outline({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}), without_backdrop(), &report);
  EXPECT_EQ(report.faces_split_concave, 1U);
  EXPECT_EQ(l_shape.polygons().size(), 2U);
  EXPECT_NEAR(total_area(l_shape), 3, 1e-12);
  check_invariants(l_shape);

  std::vector<glm::dvec2> star;
  for (int i = 0; i < 100; ++i) {
    const double angle = 2 * std::numbers::pi * i / 100;
    star.push_back((i % 2 == 0 ? 1.0 : 0.6) * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  const PolygonModel model = build_polygon_model(outline(star), without_backdrop(), &report);
  EXPECT_NEAR(total_area(model), 0.5 * 100 * 0.6 * std::sin(2 * std::numbers::pi / 100), 1e-9);
  EXPECT_EQ(report.faces_self_crossing, 0U);
  EXPECT_LT(model.polygons().size(), 98U);
  check_invariants(model);
}

TEST(BuildPolygonModel, TakesApartAFaceWithAHoleThatTouchesItself) {
  // A square ring as exporters write it: one outline, its seam walked twice.
  RawMesh mesh = outline({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}});
  mesh.faces = {{0, 1, 2, 3, 0, 4, 7, 6, 5, 4}};
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, without_backdrop(), &report);
  EXPECT_NEAR(total_area(model), 8, 1e-12);
  EXPECT_EQ(report.faces_self_crossing, 0U);
  check_invariants(model);
}

TEST(BuildPolygonModel, KeepsAHundredConvexCorners) {
  std::vector<glm::dvec2> circle;
  for (int i = 0; i < 100; ++i) {
    const double angle = 2 * std::numbers::pi * i / 100;
    circle.emplace_back(std::cos(angle), std::sin(angle));
  }
  const PolygonModel model = build_polygon_model(outline(circle), without_backdrop());
  ASSERT_EQ(model.polygons().size(), 1U);
  EXPECT_EQ(model.corners_of(0).size(), 100U);
  check_invariants(model);
}

TEST(BuildPolygonModel, DropsFacesOfThousandsOfCorners) {
  RawMesh mesh = triangulated_cube();
  mesh.faces.emplace_back();
  for (int i = 0; i < 1001; ++i) {
    const double angle = 2 * std::numbers::pi * i / 1001;
    mesh.faces.back().push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 3);
  }
  ImportReport report;
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop(), &report).polygons().size(), 6U);
  EXPECT_EQ(report.faces_too_complex, 1U);
  mesh.faces.back().pop_back();
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop(), &report).polygons().size(), 7U);
}

TEST(BuildPolygonModel, KeepsWhatItCanOfAFaceThatCrossesItself) {
  ImportReport report;
  // A bow-tie with one large and one small wing.
  const PolygonModel model =
      build_polygon_model(outline({{0, 0}, {0, 1}, {1, 0.4}, {1, 0.6}}), without_backdrop(), &report);
  EXPECT_EQ(report.faces_self_crossing + report.faces_split_concave, 2U);
  check_invariants(model);
}

TEST(BuildPolygonModel, SplitsFacesThatAreNotPlanar) {
  RawMesh mesh = outline({{0, 0}, {0.4, 0}, {0.4, 0.4}, {0, 0.4}});
  mesh.vertices[2].z += 0.1;
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, without_backdrop(), &report);
  EXPECT_EQ(report.faces_split_not_planar, 1U);
  EXPECT_EQ(model.polygons().size(), 2U);
  check_invariants(model);
  mesh.vertices[2].z = 1 + 1e-4;
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop(), &report).polygons().size(), 1U) << "within the tolerance";
  EXPECT_EQ(report.faces_split_not_planar, 0U);
}

TEST(BuildPolygonModel, CountsWhatItDrops) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  RawMesh mesh = triangulated_cube();
  mesh.vertices.insert(mesh.vertices.end(),
                       {{nan, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0}, {1e300, 0, 0}});
  mesh.vertices.insert(mesh.vertices.end(), {{0, 0, 5}, {1, 0, 5}, {2, 0, 5}});
  mesh.faces.push_back({0, 1, 8});     // NaN
  mesh.faces.push_back({0, 1, 9});     // infinite
  mesh.faces.push_back({0, 1, 10});    // beyond reason
  mesh.faces.push_back({11, 12, 13});  // zero area
  mesh.faces.push_back({11, 12});      // a line
  mesh.faces.push_back({});            // nothing
  mesh.faces.push_back({11, 11, 12});  // two distinct corners
  mesh.faces.push_back({0, 1, 99});    // bad index
  mesh.faces.push_back({0, 1, ~0U});   // bad index
  mesh.faces.push_back({3, 0, 2});     // duplicate of the first
  mesh.faces.push_back({0, 3, 2});     // duplicate, other winding
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, without_backdrop(), &report);
  EXPECT_EQ(report.faces_in, 23U);
  EXPECT_EQ(report.faces_not_finite, 3U);
  EXPECT_EQ(report.faces_degenerate, 4U);
  EXPECT_EQ(report.faces_with_bad_index, 2U);
  EXPECT_EQ(report.faces_duplicate, 2U);
  EXPECT_EQ(report.warnings.size(), 4U);
  EXPECT_EQ(model.polygons().size(), 6U);
  check_invariants(model);
}

TEST(BuildPolygonModel, DropsWhiskersAndRepeatedCorners) {
  RawMesh mesh = outline({{0, 0}, {0.3, 0}, {0.3, 0.3}, {0, 0.3}, {0.6, 0.6}});
  mesh.faces = {{0, 0, 1, 2, 4, 2, 3, 3}};
  const PolygonModel model = build_polygon_model(mesh, without_backdrop());
  ASSERT_EQ(model.polygons().size(), 1U);
  EXPECT_EQ(model.corners_of(0).size(), 4U);
  EXPECT_NEAR(total_area(model), 0.09, 1e-12);
}

TEST(BuildPolygonModel, CutsThreeFacesOnAnEdgeApartButKnowsThemAsNeighbours) {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0.2, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, without_backdrop(), &report);
  EXPECT_EQ(model.polygons().size(), 3U);
  EXPECT_EQ(report.edges_not_manifold, 1U);
  EXPECT_GE(report.vertices_split, 4U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(model.neighbours_of(i).size(), 2U);
  check_invariants(model);
}

TEST(BuildPolygonModel, SplitsAVertexWhereTwoFansMeet) {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 3, 4}};
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, without_backdrop(), &report);
  EXPECT_EQ(report.vertices_split, 1U);
  EXPECT_EQ(model.vertices().size(), 6U);
  EXPECT_EQ(report.boundary_edges, 6U);
  EXPECT_EQ(report.boundary_loops, 2U);
}

TEST(BuildPolygonModel, SurvivesAMoebiusStripAndManyFacesOnOneEdge) {
  RawMesh mesh;
  constexpr int n = 12;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    const glm::dvec3 out(std::cos(a), std::sin(a), 0);
    const glm::dvec3 side = std::cos(a / 2) * out + glm::dvec3(0, 0, std::sin(a / 2));
    mesh.vertices.push_back(out - 0.3 * side);
    mesh.vertices.push_back(out + 0.3 * side);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = 2 * i;
    const bool last = i + 1 == n;
    const std::uint32_t c = last ? 1 : a + 2;
    const std::uint32_t d = last ? 0 : a + 3;
    mesh.faces.push_back({a, a + 1, d});
    mesh.faces.push_back({a, d, c});
  }
  ImportReport report;
  check_invariants(build_polygon_model(mesh, without_backdrop(), &report));
  EXPECT_EQ(report.edges_with_opposed_winding, 1U);

  RawMesh book;
  book.vertices = {{0, 0, 0}, {0, 0, 1}};
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const double a = 2 * std::numbers::pi * i / 5000;
    book.vertices.emplace_back(std::cos(a), std::sin(a), 0);
    book.faces.push_back({0, 1, i + 2});
  }
  const PolygonModel model = build_polygon_model(book, without_backdrop());
  EXPECT_EQ(model.polygons().size(), 5000U);
  check_invariants(model);
}

TEST(BuildPolygonModel, WeldsEqualAndOnRequestCloseVertices) {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.2, 0}, {0, -0.0, 0}, {0.2, 0.2, 0}, {0, 0.2, 0}};
  mesh.faces = {{0, 1, 2}, {3, 4, 5}};
  ImportReport report;
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop(), &report).polygons().size(), 1U);
  EXPECT_EQ(report.vertices_welded, 2U);
  mesh.vertices[3].x += 1e-5;
  EXPECT_EQ(build_polygon_model(mesh, without_backdrop()).polygons().size(), 2U);
  ImportOptions options = without_backdrop();
  options.weld_distance = 1e-4;
  EXPECT_EQ(build_polygon_model(mesh, options).polygons().size(), 1U);
}

TEST(BuildPolygonModel, RefusesWhatCannotBeUsedInOneClearLine) {
  EXPECT_THROW((void)build_polygon_model(RawMesh{}, {}), InputError);
  RawMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.faces = {{0, 1, 2}};
  try {
    (void)build_polygon_model(flat, {}, nullptr, "flat.obj");
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.rfind("flat.obj: has no usable face", 0), 0U) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos);
  }
  ImportOptions options;
  options.scale = 0;
  EXPECT_THROW((void)build_polygon_model(triangulated_cube(), options), InputError);
  options.scale = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)build_polygon_model(triangulated_cube(), options), InputError);
  options = {};
  options.weld_distance = 1e-300;
  EXPECT_THROW((void)build_polygon_model(triangulated_cube(), options), InputError);
  RawMesh mesh = triangulated_cube();
  mesh.face_part = {0};
  EXPECT_THROW((void)build_polygon_model(mesh, {}), InputError);
}

TEST(BuildPolygonModel, AppliesTheScale) {
  ImportOptions options = without_backdrop();
  options.scale = 0.001;
  ImportReport report;
  (void)build_polygon_model(triangulated_cube(), options, &report);
  EXPECT_NEAR(report.bounds_max.x, 0.0002, 1e-15);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_NE(report.warnings[0].find("scale"), std::string::npos);
}

TEST(BuildPolygonModel, PutsAFarBoxAroundTheScene) {
  RawMesh mesh = triangulated_cube();
  for (glm::dvec3& vertex : mesh.vertices) vertex += glm::dvec3(3, 4, 5);
  ImportReport report;
  const PolygonModel model = build_polygon_model(mesh, {}, &report);
  EXPECT_EQ(report.backdrop_polygons, 6U * 25U);
  EXPECT_EQ(model.polygons().size(), 6U + 150U);
  ASSERT_EQ(model.parts().size(), 2U);
  EXPECT_EQ(model.part_index("backdrop"), 1);
  const double radius = 0.2 * std::sqrt(3.0);
  for (std::size_t i = 6; i < model.polygons().size(); ++i) {
    const Polygon& polygon = model.polygons()[i];
    EXPECT_TRUE(polygon.is_backdrop);
    EXPECT_EQ(polygon.part, 1U);
    // Seen from the scene's centre: the front, 100 radii away.
    EXPECT_NEAR(glm::dot(polygon.normal, glm::dvec3(3, 4, 5)) - polygon.offset, 100 * radius, 1e-6);
    EXPECT_EQ(model.neighbours_of(i).size(), 4U);
    const PolygonFrame frame = polygon_frame(model, i);
    EXPECT_NEAR(frame.extent.x * polygon.texels_per_metre, 256, 1e-6);
    EXPECT_GE(polygon.texels_per_metre * 100 * radius, 600 - 1e-6) << "texels per radian at a side's centre";
  }
  check_invariants(model, 1e-3, 1e-3);
  mesh.part_names = {"backdrop"};
  const PolygonModel renamed = build_polygon_model(mesh, {}, &report);
  EXPECT_EQ(renamed.part_index("backdrop"), 1);
  EXPECT_EQ(report.warnings.size(), 1U);
}

TEST(PolygonModel, FingerprintChangesWithWhatTexturesDependOnAndWithNothingElse) {
  const std::uint64_t plain = build_polygon_model(triangulated_cube(), {}).fingerprint();
  EXPECT_EQ(build_polygon_model(triangulated_cube(), {}).fingerprint(), plain);
  // Pinned: saved textures of one machine must load on another.
  EXPECT_EQ(plain, 17644509455093636965ULL);
  RawMesh moved = triangulated_cube();
  moved.vertices[3].x = std::nextafter(moved.vertices[3].x, 1.0);
  EXPECT_NE(build_polygon_model(moved, {}).fingerprint(), plain);
  RawMesh named = triangulated_cube();
  named.part_names = {"cube"};
  EXPECT_NE(build_polygon_model(named, {}).fingerprint(), plain);
  RawMesh reordered = triangulated_cube();
  std::swap(reordered.faces[0], reordered.faces[6]);
  EXPECT_NE(build_polygon_model(reordered, {}).fingerprint(), plain);
  EXPECT_NE(build_polygon_model(triangulated_cube(), without_backdrop()).fingerprint(), plain);
}

TEST(PolygonFrameTest, IsTheSmallestBoxAlongAnEdge) {
  // A rectangle of 3 x 1, turned by 30 degrees in the plane z = 1.
  const double c = std::cos(std::numbers::pi / 6);
  const double s = std::sin(std::numbers::pi / 6);
  const auto turned = [&](double x, double y) { return glm::dvec2(c * x - s * y, s * x + c * y); };
  ImportOptions options = without_backdrop();
  const PolygonModel model =
      build_polygon_model(outline({turned(0, 0), turned(3, 0), turned(3, 1), turned(0, 1)}), options);
  const PolygonFrame frame = polygon_frame(model, 0);
  // The first edge, of length 3, is the y axis; x = y cross n points away from the polygon's left.
  EXPECT_NEAR(frame.extent.y, 3, 1e-12);
  EXPECT_NEAR(frame.extent.x, 1, 1e-12);
  const glm::dvec3 expected = glm::cross(frame.y_axis, model.polygons()[0].normal);
  EXPECT_NEAR(glm::distance(frame.x_axis, expected), 0, 1e-12);
  glm::dvec2 low(1e9);
  glm::dvec2 high(-1e9);
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2 q = frame.plane_from_part(model.corner(0, i));
    low = glm::min(low, q);
    high = glm::max(high, q);
    EXPECT_NEAR(glm::distance(frame.part_from_plane(q), model.corner(0, i)), 0, 1e-12);
  }
  EXPECT_NEAR(glm::length(low), 0, 1e-12);
  EXPECT_NEAR(glm::distance(high, frame.extent), 0, 1e-12);
}

class SharedMesh : public testing::TestWithParam<const char*> {};

TEST_P(SharedMesh, KeepsTheInvariants) {
  const std::filesystem::path file = std::filesystem::path(FOREVIEW_SHARED_DIR) / GetParam();
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared data is not here: " << file;
  ImportReport report;
  const RawMesh mesh = read_mesh(file);
  const PolygonModel model = build_polygon_model(mesh, {}, &report, file.string());
  check_invariants(model);
  ImportOptions options;
  options.merge_coplanar = false;
  const double area = total_area(build_polygon_model(mesh, options));
  EXPECT_NEAR(total_area(model) / area, 1, 2e-3) << "merging loses no surface";
}
INSTANTIATE_TEST_SUITE_P(Kitchen, SharedMesh,
                         testing::Values("recordings/kitchen/scene_5k.ply", "recordings/kitchen/scene.ply"));
INSTANTIATE_TEST_SUITE_P(
    So100, SharedMesh,
    testing::Values("robots/so100/assets/Lower_Arm.stl", "robots/so100/assets/Moving_Jaw.stl",
                    "robots/so100/assets/Fixed_Jaw_Motor.stl", "robots/so100/assets/Upper_Arm.stl",
                    "robots/so100/assets/Rotation_Pitch.stl", "robots/so100/assets/Base.stl",
                    "robots/so100/assets/Rotation_Pitch_Motor.stl", "robots/so100/assets/Fixed_Jaw.stl",
                    "robots/so100/assets/Wrist_Pitch_Roll.stl", "robots/so100/assets/Wrist_Pitch_Roll_Motor.stl",
                    "robots/so100/assets/Lower_Arm_Motor.stl", "robots/so100/assets/Upper_Arm_Motor.stl",
                    "robots/so100/assets/Base_Motor.stl"));

}  // namespace
}  // namespace foreview
