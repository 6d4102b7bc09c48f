#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// Quads of 0.1 m in the plane z = 0, facing +z: one row for each of `rows`, with so many quads, 1 m apart; quads of a
/// row are neighbours. Row i is part i. Polygons come in that order.
[[nodiscard]] inline PolygonModel rows_of_quads(const std::vector<int>& rows) {
  RawMesh mesh;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int i = 0; i <= rows[row]; ++i) {
      mesh.vertices.emplace_back(0.1 * i, static_cast<double>(row), 0.0);
      mesh.vertices.emplace_back(0.1 * i, static_cast<double>(row) + 0.1, 0.0);
    }
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rows[row]); ++i) {
      const std::uint32_t at = first + 2 * i;
      mesh.faces.push_back({at, at + 2, at + 3, at + 1});
      mesh.face_part.push_back(static_cast<std::uint32_t>(row));
    }
    mesh.part_names.push_back("row" + std::to_string(row));
  }
  ImportOptions options;
  options.merge_coplanar = false;
  options.backdrop = false;
  return build_polygon_model(mesh, options);
}

/// Charts of the given sizes (texels) one beside the other in shelves, with no texel between them: the tightest
/// neighbourhood that the alignment allows. The polygon spans the chart less the gutter.
[[nodiscard]] inline ChartLayout tight_layout(const PolygonModel& model, const std::vector<glm::ivec2>& sizes,
                                              int page_size) {
  ChartLayout layout;
  layout.page_size = page_size;
  layout.pages = 1;
  glm::ivec2 at{0, 0};
  int shelf = 0;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    Chart chart;
    chart.size = sizes[i % sizes.size()];
    if (at.x + chart.size.x > page_size) at = {0, at.y + shelf}, shelf = 0;
    if (at.y + chart.size.y > page_size) at = {0, 0}, shelf = 0, ++layout.pages;
    chart.page = layout.pages - 1;
    chart.origin = at;
    at.x += chart.size.x;
    shelf = std::max(shelf, chart.size.y);
    chart.frame = polygon_frame(model, i);
    chart.inner = chart.size - 2 * kChartGutter;
    chart.texels_per_metre = glm::dvec2(chart.inner) / chart.frame.extent;
    chart.normal = model.polygons()[i].normal;
    chart.offset = model.polygons()[i].offset;
    chart.group = static_cast<std::uint32_t>(i);
    layout.charts.push_back(chart);
    layout.groups.push_back({chart.page, chart.origin, chart.size, chart.inner, chart.group, 1});
    layout.members.push_back(chart.group);
  }
  layout.outline.assign(model.corners().size(), true);
  return layout;
}

}  // namespace foreview
