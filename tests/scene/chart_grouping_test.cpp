#include "foreview/scene/chart_grouping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "chart_invariants.h"
#include "foreview/scene/chart_layout.h"

namespace foreview {
namespace {

constexpr double kDensity = 100;  // texels per metre: 1 cm is a texel

PolygonModel model_of(const RawMesh& mesh) {
  ImportOptions options;
  options.merge_coplanar = false;
  options.backdrop = false;
  return build_polygon_model(mesh, options);
}

/// columns x rows cells of two triangles each; corners at place(column, row), shared where cells meet. Fronts are on
/// the side from which columns to the right and rows upwards are counter-clockwise.
RawMesh sheet(
    int columns, int rows, const std::function<glm::dvec3(int, int)>& place,
    const std::function<bool(int, int)>& has_cell = [](int, int) { return true; }) {
  RawMesh mesh;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x) mesh.vertices.push_back(place(x, y));
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (columns + 1) + x); };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (!has_cell(x, y)) continue;
      mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  return mesh;
}

/// A rough surface with cells of this size (metres), and roughness in cells.
RawMesh rough_sheet(int cells, double size, double roughness, unsigned seed = 1) {
  std::mt19937 random(seed);
  const auto next = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  return sheet(cells, cells, [&](int x, int y) {
    return size * glm::dvec3(x + 0.5 * roughness * next(), y + 0.5 * roughness * next(), 2 * roughness * next());
  });
}

ChartLayout lay_out(const PolygonModel& model, double density = kDensity, int max_texels = 256) {
  ChartOptions options;
  options.texels_per_metre = density;
  options.max_texels = max_texels;
  ChartLayout layout = lay_out_charts(model, options);
  check_layout(model, layout);
  check_groups(model, layout, max_texels);
  return layout;
}

TEST(ChartGrouping, AFlatSheetIsOneGroup) {
  const PolygonModel model = model_of(sheet(20, 10, [](int x, int y) { return glm::dvec3(0.05 * x, 0.05 * y, 1); }));
  const ChartLayout layout = lay_out(model);
  ASSERT_EQ(layout.groups.size(), 1U);
  EXPECT_EQ(std::max(layout.groups[0].inner.x, layout.groups[0].inner.y), 100);
  EXPECT_EQ(std::min(layout.groups[0].inner.x, layout.groups[0].inner.y), 50);
  EXPECT_NEAR(layout.useful_texels, 5000, 1e-6);
  EXPECT_NEAR(layout.written_texels, 5000 + 300 * kChartGutter + std::numbers::pi * kChartGutter * kChartGutter, 1e-6);
  EXPECT_EQ(std::count(layout.outline.begin(), layout.outline.end(), true), 60);
}

TEST(ChartGrouping, CanBeSwitchedOff) {
  const PolygonModel model = model_of(sheet(4, 4, [](int x, int y) { return glm::dvec3(0.1 * x, 0.1 * y, 0); }));
  ChartOptions options;
  options.group_polygons = false;
  const ChartLayout layout = lay_out_charts(model, options);
  check_layout(model, layout);
  EXPECT_EQ(layout.groups.size(), 32U);
  EXPECT_EQ(std::count(layout.outline.begin(), layout.outline.end(), false), 0);
}

TEST(ChartGrouping, NoGroupIsLongerThanAllowed) {
  const PolygonModel model = model_of(sheet(40, 40, [](int x, int y) { return glm::dvec3(0.05 * x, 0.05 * y, 0); }));
  const ChartLayout layout = lay_out(model, kDensity, 64);
  EXPECT_GE(layout.groups.size(), 11U) << "2 m x 2 m in pieces of 0.64 m";
  EXPECT_LE(layout.groups.size(), 30U);
  EXPECT_EQ(layout.polygons_capped, 0U);
}

TEST(ChartGrouping, LongPolygonsKeepTheirOwnDensityAlone) {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {4, 0, 0}, {4, 0.1, 0}, {0, 0.1, 0}, {0.1, 0.2, 0}, {0, 0.2, 0}};
  mesh.faces = {{0, 1, 2, 3}, {3, 2, 4}, {3, 4, 5}};
  const ChartLayout layout = lay_out(model_of(mesh));
  EXPECT_EQ(layout.groups.size(), 3U) << "the second is long as well";
  EXPECT_EQ(layout.polygons_capped, 2U);
  EXPECT_EQ(layout.charts[2].texels_per_metre, glm::dvec2(kDensity));
}

TEST(ChartGrouping, RoughSheetsOfAllSizes) {
  // Triangles from a third of a texel to 40 texels wide, from smooth to crumpled.
  for (const double texels : {0.3, 1.0, 3.0, 10.0, 40.0}) {
    for (const double roughness : {0.0, 0.2, 0.6, 1.5}) {
      SCOPED_TRACE(testing::Message() << texels << " texels, roughness " << roughness);
      const PolygonModel model = model_of(rough_sheet(14, texels / kDensity, roughness));
      const ChartLayout layout = lay_out(model);
      if (roughness <= 0.2 && texels < 20) {
        EXPECT_EQ(layout.groups.size(), 1U);
      } else {
        EXPECT_LT(layout.groups.size(), model.polygons().size() * 3 / 4);
      }
    }
  }
}

TEST(ChartGrouping, CubeHasSixGroups) {
  RawMesh mesh;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const RawMesh face = sheet(5, 5, [&](int x, int y) {
      const double sign = side % 2 == 0 ? 1 : -1;
      glm::dvec3 p;
      p[axis] = 0.25 * sign;
      p[(axis + 1) % 3] = sign * (0.1 * x - 0.25);
      p[(axis + 2) % 3] = 0.1 * y - 0.25;
      return p;
    });
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), face.vertices.begin(), face.vertices.end());
    for (auto corners : face.faces) {
      for (std::uint32_t& corner : corners) corner += first;
      mesh.faces.push_back(corners);
    }
  }
  EXPECT_EQ(lay_out(model_of(mesh)).groups.size(), 6U);
}

TEST(ChartGrouping, CylinderIsCutWhereItTurnsAway) {
  constexpr int kSides = 48;
  const RawMesh mesh = sheet(kSides, 10, [](int x, int y) {
    const double angle = 2 * std::numbers::pi * (x % kSides) / kSides;
    return glm::dvec3(0.2 * std::cos(angle), 0.2 * std::sin(angle), 0.04 * y);
  });
  const ChartLayout layout = lay_out(model_of(mesh));
  EXPECT_GE(layout.groups.size(), 4U);
  EXPECT_LE(layout.groups.size(), 12U);
}

TEST(ChartGrouping, FoldedStripIsCutAtItsFolds) {
  // As a folded map: every panel is inclined by 60 degrees to the whole, and by 120 to the next.
  const RawMesh mesh = sheet(6 * 8, 10, [](int x, int y) {
    const int panel = x / 8;
    const double along = x % 8 / 8.0;
    const double height = panel % 2 == 0 ? along : 1 - along;
    return glm::dvec3(0.1 * (panel + along), 0.03 * y, 0.1 * std::sqrt(3.0) * height);
  });
  EXPECT_EQ(lay_out(model_of(mesh)).groups.size(), 6U);
}

TEST(ChartGrouping, RampOfACarParkDoesNotCoverItself) {
  // Every turn lies over the one below, and all is connected and nearly level.
  const RawMesh mesh = sheet(4, 96, [](int x, int y) {
    const double angle = 2 * std::numbers::pi * y / 32;
    return glm::dvec3((0.2 + 0.05 * x) * glm::dvec2(std::cos(angle), std::sin(angle)), 0.01 * y / 32);
  });
  const ChartLayout layout = lay_out(model_of(mesh));
  EXPECT_GE(layout.groups.size(), 3U);
  EXPECT_LE(layout.groups.size(), 12U);
}

TEST(ChartGrouping, HairpinHasTwoGroups) {
  // A sheet that is bent back over itself, a millimetre above: the sides face away from each other.
  const RawMesh mesh = sheet(10, 10, [](int x, int y) {
    return x <= 5 ? glm::dvec3(0.05 * x, 0.05 * y, 0) : glm::dvec3(0.05 * (11 - x), 0.05 * y, 0.001);
  });
  EXPECT_EQ(lay_out(model_of(mesh)).groups.size(), 3U) << "the narrow back is the third";
}

/// A sheet with a slit up from its lower edge, between the columns 7 and 8, of this width at all rows but the last.
RawMesh slit_sheet(double width) {
  return sheet(
      15, 10, [&](int x, int y) { return glm::dvec3(0.05 * (x <= 7 ? x : x - 1) + (x <= 7 ? 0 : width), 0.05 * y, 0); },
      [](int x, int y) { return x != 7 || y == 9; });
}

TEST(ChartGrouping, SidesOfANarrowSlitShareNoGroup) {
  const PolygonModel model = model_of(slit_sheet(0.015));
  const ChartLayout layout = lay_out(model);
  EXPECT_GT(layout.groups.size(), 1U);
  const auto group_at = [&](double x, double y) {
    for (std::size_t i = 0; i < model.polygons().size(); ++i) {
      const glm::dvec3 middle = (model.corner(i, 0) + model.corner(i, 1) + model.corner(i, 2)) / 3.0;
      if (std::abs(middle.x - x) < 0.03 && std::abs(middle.y - y) < 0.03) return layout.charts[i].group;
    }
    ADD_FAILURE();
    return 0U;
  };
  EXPECT_NE(group_at(0.325, 0.025), group_at(0.39, 0.025));
}

TEST(ChartGrouping, AWideSlitDoesNotMatter) {
  EXPECT_EQ(lay_out(model_of(slit_sheet(0.03))).groups.size(), 1U);
}

TEST(ChartGrouping, PartsAndTheBackdropStayApart) {
  RawMesh mesh = sheet(4, 4, [](int x, int y) { return glm::dvec3(0.1 * x, 0.1 * y, 0); });
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) mesh.face_part.push_back(i < 16 ? 0 : 1);
  mesh.part_names = {"lower", "upper"};
  ImportOptions options;
  options.merge_coplanar = false;
  const PolygonModel model = build_polygon_model(mesh, options);
  const ChartLayout layout = lay_out(model);
  std::size_t backdrop = 0;
  for (const Polygon& polygon : model.polygons()) backdrop += polygon.is_backdrop ? 1 : 0;
  EXPECT_GT(backdrop, 0U);
  EXPECT_EQ(layout.groups.size(), 2 + backdrop);
}

TEST(ChartGrouping, SoupStaysApart) {
  std::mt19937 random(7);
  const auto next = [&] { return static_cast<double>(random()) / 4294967296.0; };
  RawMesh mesh;
  for (std::uint32_t i = 0; i < 600; ++i) {
    const glm::dvec3 at(2 * next(), 2 * next(), 2 * next());
    const double size = 0.5 * next() * next();
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(at + size * glm::dvec3(next(), next(), next()));
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const PolygonModel model = model_of(mesh);
  EXPECT_EQ(lay_out(model).groups.size(), model.polygons().size());
}

TEST(ChartGrouping, TangledMeshesKeepTheRules) {
  // Few vertices, many triangles at random between them: edges of many faces, folds, overlaps, needles.
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto next = [&] { return static_cast<double>(random()) / 4294967296.0; };
    RawMesh mesh;
    const double flatness = seed % 3 == 0 ? 0.02 : seed % 3 == 1 ? 0.3 : 1.0;
    for (int i = 0; i < 40; ++i) mesh.vertices.emplace_back(next(), next(), flatness * next());
    for (int i = 0; i < 300; ++i) {
      std::vector<std::uint32_t> corners;
      for (int k = 0; k < 3; ++k) corners.push_back(static_cast<std::uint32_t>(random() % 40));
      mesh.faces.push_back(corners);
    }
    const PolygonModel model = model_of(mesh);
    const ChartLayout layout = lay_out(model);
    if (flatness < 0.1) {
      EXPECT_LT(layout.groups.size(), model.polygons().size());
    }
    (void)lay_out(model, 3);
    (void)lay_out(model, 1000, 64);
  }
}

TEST(ChartGrouping, NeedlesAndSpecksGiveFiniteMaps) {
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0},        {0.2, 0, 0},         {0.1, 1e-5, 0}, {0.1, 0.2, 0},
                   {1e-5, -1e-5, 0}, {2e-5, -1e-5, 1e-5}, {-1e-5, 0, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {2, 1, 3}, {4, 0, 6}, {4, 5, 0}};
  const PolygonModel model = model_of(mesh);
  ASSERT_EQ(model.polygons().size(), 5U);
  const ChartLayout layout = lay_out(model, 1e4);
  for (const Chart& chart : layout.charts) {
    EXPECT_TRUE(std::isfinite(chart.texels_per_metre.x + chart.texels_per_metre.y));
    EXPECT_TRUE(std::isfinite(glm::length(chart.frame.origin) + glm::length(chart.frame.x_axis)));
  }
  (void)lay_out(model, 1);
}

TEST(ChartGrouping, IsTheSameEveryTime) {
  const PolygonModel model = model_of(rough_sheet(30, 0.05, 0.8));
  const ChartLayout a = lay_out_charts(model, {});
  const ChartLayout b = lay_out_charts(model, {});
  EXPECT_EQ(a.members, b.members);
  EXPECT_EQ(a.outline, b.outline);
  for (std::size_t i = 0; i < a.charts.size(); ++i) {
    ASSERT_EQ(a.charts[i].origin, b.charts[i].origin);
    ASSERT_EQ(a.charts[i].frame.origin, b.charts[i].frame.origin);
    ASSERT_EQ(a.charts[i].frame.y_axis, b.charts[i].frame.y_axis);
  }
}

TEST(ChartGrouping, BudgetKeepsMembersApart) {
  // Many slits, some of them narrow only once the density is lowered.
  RawMesh mesh;
  for (int i = 0; i < 12; ++i) {
    const RawMesh one = slit_sheet(0.01 + 0.005 * i);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const glm::dvec3& p : one.vertices) mesh.vertices.push_back(p + glm::dvec3(0, 0, i));
    for (auto corners : one.faces) {
      for (std::uint32_t& corner : corners) corner += first;
      mesh.faces.push_back(corners);
    }
  }
  const PolygonModel model = model_of(mesh);
  ChartOptions options;
  options.texels_per_metre = kDensity * 3;
  const ChartLayout full = lay_out_charts(model, options);
  for (const std::size_t share : {2U, 4U, 8U}) {
    options.memory_budget = full.memory_bytes / share;
    const ChartLayout lowered = lay_out_charts(model, options);
    check_layout(model, lowered);
    check_groups(model, lowered, options.max_texels);
    EXPECT_LE(lowered.memory_bytes, options.memory_budget);
    EXPECT_GT(lowered.polygons_lowered, 0U);
    ASSERT_EQ(lowered.notes.size(), 1U);
    EXPECT_NE(lowered.notes[0].find("budget"), std::string::npos);
  }
}

TEST(ChartGrouping, KitchenIsEconomical) {
  const std::filesystem::path folder = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::exists(folder / "scene.ply")) GTEST_SKIP() << "shared data is not here: " << folder;
  ChartOptions options;
  options.texels_per_metre = 200;
  for (const auto& [file, most_groups, most_written] :
       {std::tuple("scene.ply", 3000U, 1.5), {"scene_5k.ply", 1000U, 1.35}}) {
    const PolygonModel model = import_model(folder / file, {});
    const ChartLayout layout = lay_out_charts(model, options);
    check_layout(model, layout);
    check_groups(model, layout, options.max_texels);
    EXPECT_LT(layout.written_texels / layout.useful_texels, most_written) << file;
    EXPECT_LT(layout.groups.size(), most_groups) << file;
    // Inclination takes little from what is useful.
    options.group_polygons = false;
    EXPECT_GT(layout.useful_texels, 0.95 * lay_out_charts(model, options).useful_texels) << file;
    options.group_polygons = true;
  }
}

}  // namespace
}  // namespace foreview
