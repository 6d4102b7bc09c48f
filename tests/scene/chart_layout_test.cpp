#include "foreview/scene/chart_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "chart_invariants.h"
#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr double kGutter = kChartGutter;

/// Rectangles side by side in the plane z = 0, with a gap, so that none is merged.
PolygonModel rectangles(const std::vector<glm::dvec2>& sizes, bool backdrop = false) {
  RawMesh mesh;
  double x = 0;
  for (const glm::dvec2& size : sizes) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x + size.x, 0, 0}, {x + size.x, size.y, 0}, {x, size.y, 0}});
    mesh.faces.push_back({first, first + 1, first + 2, first + 3});
    x += size.x + 0.1;
  }
  ImportOptions options;
  options.backdrop = backdrop;
  return build_polygon_model(mesh, options);
}

/// Many triangles of mixed sizes and shapes, deterministic.
PolygonModel many_triangles(std::size_t count) {
  RawMesh mesh;
  std::uint32_t state = 1;
  const auto random = [&state] {
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 8) / (1 << 24);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double size = 0.02 + 0.6 * random() * random();
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const glm::dvec3 at(3 * random(), 3 * random(), 3 * random());
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(at + size * glm::dvec3(random(), random(), random()));
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  ImportOptions options;
  options.backdrop = false;
  return build_polygon_model(mesh, options);
}

TEST(ChartLayoutTest, GivesARectangleItsTexelsAndAGutter) {
  const PolygonModel model = rectangles({{0.2, 0.1}});
  const ChartLayout layout = lay_out_charts(model, {});
  check_layout(model, layout);
  const Chart& chart = layout.charts[0];
  EXPECT_EQ(chart.inner, glm::ivec2(50, 100)) << "y runs along the first edge, which is 0.2 m long";
  EXPECT_EQ(chart.size, glm::ivec2(64, 112));
  EXPECT_EQ(chart.texels_per_metre, glm::dvec2(500));
  EXPECT_EQ(layout.pages, 1U);
  EXPECT_EQ(layout.page_size, 256);
  EXPECT_NEAR(layout.useful_texels, 5000, 1e-6);
  EXPECT_NEAR(layout.written_texels, 5000 + 300 * 2 + 4 * 3.14159265, 1e-3);
  EXPECT_EQ(layout.polygons_capped, 0U);
  const glm::dvec2 texel(13.25, 40.75);
  EXPECT_NEAR(glm::distance(chart.texel_from_part(chart.part_from_texel(texel)), texel), 0, 1e-9);
}

TEST(ChartLayoutTest, CountsTexelsHonestly) {
  // The formula for written texels against counting them, for a triangle.
  RawMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.3, 0, 0}, {0.05, 0.2, 0}};
  mesh.faces = {{0, 1, 2}};
  ImportOptions options;
  options.backdrop = false;
  const PolygonModel model = build_polygon_model(mesh, options);
  const ChartLayout layout = lay_out_charts(model, {});
  const Chart& chart = layout.charts[0];
  std::vector<glm::dvec2> corners;
  for (std::size_t i = 0; i < 3; ++i) corners.push_back(chart.texel_from_part(model.corner(0, i)));
  double counted = 0;
  double inside = 0;
  for (int y = 0; y < chart.size.y; ++y) {
    for (int x = 0; x < chart.size.x; ++x) {
      const glm::dvec2 p = glm::dvec2(chart.origin) + glm::dvec2(x + 0.5, y + 0.5);
      double nearest = 1e9;
      int lefts = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 a = corners[i];
        const glm::dvec2 edge = corners[(i + 1) % 3] - a;
        const double t = std::clamp(glm::dot(p - a, edge) / glm::dot(edge, edge), 0.0, 1.0);
        nearest = std::min(nearest, glm::distance(p, a + t * edge));
        lefts += edge.x * (p.y - a.y) - edge.y * (p.x - a.x) > 0 ? 1 : 0;
      }
      const bool in = lefts == 0 || lefts == 3;
      inside += in ? 1 : 0;
      counted += in || nearest <= kGutter ? 1 : 0;
    }
  }
  EXPECT_NEAR(layout.useful_texels / inside, 1, 0.01);
  EXPECT_NEAR(layout.written_texels / counted, 1, 0.01);
}

TEST(ChartLayoutTest, LimitsTheLongerAxisOnly) {
  const PolygonModel model = rectangles({{2.0, 0.1}, {0.1, 0.1}});
  const ChartLayout layout = lay_out_charts(model, {});
  EXPECT_EQ(layout.polygons_capped, 1U);
  EXPECT_EQ(layout.charts[0].inner, glm::ivec2(50, 256));
  EXPECT_DOUBLE_EQ(layout.charts[0].texels_per_metre.x, 500);
  EXPECT_DOUBLE_EQ(layout.charts[0].texels_per_metre.y, 128);
}

TEST(ChartLayoutTest, GivesTheThinnestPolygonATexel) {
  const PolygonModel model = rectangles({{1e-5, 0.3}, {1e-5, 1e-5}});
  const ChartLayout layout = lay_out_charts(model, {});
  check_layout(model, layout);
  EXPECT_EQ(layout.charts[1].inner, glm::ivec2(1, 1));
}

TEST(ChartLayoutTest, PacksThousandsWithoutOverlapAndTightly) {
  const PolygonModel model = many_triangles(5000);
  ChartOptions options;
  const ChartLayout layout = lay_out_charts(model, options);
  check_layout(model, layout);
  EXPECT_GT(layout.pages, 1U);
  std::size_t used = 0;
  for (const ChartGroup& chart : layout.groups) used += static_cast<std::size_t>(chart.size.x) * chart.size.y;
  EXPECT_GT(static_cast<double>(used) / static_cast<double>(layout.allocated_texels), 0.85);
  const ChartLayout again = lay_out_charts(model, options);
  for (std::size_t i = 0; i < layout.charts.size(); ++i) {
    ASSERT_EQ(layout.charts[i].origin, again.charts[i].origin);
    ASSERT_EQ(layout.charts[i].page, again.charts[i].page);
  }
}

TEST(ChartLayoutTest, ShrinksThePageInStepsOf256) {
  const PolygonModel model = many_triangles(300);
  const ChartLayout layout = lay_out_charts(model, {});
  check_layout(model, layout);
  EXPECT_EQ(layout.pages, 1U);
  EXPECT_LT(layout.page_size, 4096);
  EXPECT_EQ(layout.page_size % 256, 0);
}

TEST(ChartLayoutTest, BudgetLowersTheLargestFirstAndSaysSo) {
  const PolygonModel model = many_triangles(2000);
  ChartOptions options;
  const ChartLayout full = lay_out_charts(model, options);
  options.memory_budget = full.memory_bytes / 3;
  const ChartLayout lowered = lay_out_charts(model, options);
  check_layout(model, lowered);
  EXPECT_LE(lowered.memory_bytes, options.memory_budget);
  EXPECT_GT(lowered.memory_bytes, options.memory_budget / 2) << "no more lowered than it must be";
  ASSERT_EQ(lowered.notes.size(), 1U);
  EXPECT_NE(lowered.notes[0].find("budget"), std::string::npos);
  std::size_t changed = 0;
  int smallest_changed = 1 << 30;
  int largest_kept = 0;
  for (std::size_t i = 0; i < full.charts.size(); ++i) {
    const int wanted = std::max(full.charts[i].inner.x, full.charts[i].inner.y);
    if (full.charts[i].texels_per_metre != lowered.charts[i].texels_per_metre) {
      ++changed;
      smallest_changed = std::min(smallest_changed, wanted);
    } else {
      largest_kept = std::max(largest_kept, wanted);
    }
  }
  EXPECT_EQ(changed, lowered.polygons_lowered);
  EXPECT_GT(changed, 0U);
  EXPECT_LE(largest_kept, smallest_changed);
  options.memory_budget = 100'000;
  EXPECT_THROW((void)lay_out_charts(model, options), InputError);
}

TEST(ChartLayoutTest, BackdropKeepsItsOwnDensity) {
  const PolygonModel model = rectangles({{0.4, 0.4}}, true);
  ChartOptions options;
  options.max_texels = 64;
  const ChartLayout layout = lay_out_charts(model, options);
  check_layout(model, layout);
  EXPECT_EQ(layout.charts[0].inner, glm::ivec2(64, 64));
  EXPECT_EQ(layout.charts[1].inner, glm::ivec2(256, 256));
}

TEST(ChartLayoutTest, SmallPagesHoldSmallerCharts) {
  const PolygonModel model = rectangles({{0.5, 0.5}, {0.3, 0.3}});
  ChartOptions options;
  options.page_size = 200;
  const ChartLayout layout = lay_out_charts(model, options);
  check_layout(model, layout);
  EXPECT_LE(layout.page_size, 200);
  EXPECT_FALSE(layout.notes.empty());
}

TEST(ChartLayoutTest, RefusesImpossibleOptions) {
  const PolygonModel model = rectangles({{0.5, 0.5}});
  const auto refused = [&](const ChartOptions& options) {
    EXPECT_THROW((void)lay_out_charts(model, options), InputError);
  };
  ChartOptions options;
  options.texels_per_metre = 0;
  refused(options);
  options.texels_per_metre = std::nan("");
  refused(options);
  options = {};
  options.max_texels = 0;
  refused(options);
  options = {};
  options.page_size = 8;
  refused(options);
}

TEST(ChartLayoutTest, KitchenFits) {
  const std::filesystem::path file = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen/scene_5k.ply";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared data is not here: " << file;
  const PolygonModel model = import_model(file, {});
  ChartOptions options;
  options.texels_per_metre = 200;
  const ChartLayout layout = lay_out_charts(model, options);
  check_layout(model, layout);
  EXPECT_LT(layout.written_texels / layout.useful_texels, 2);
}

}  // namespace
}  // namespace foreview
