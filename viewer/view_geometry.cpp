#include "foreview/viewer/view_geometry.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <glm/common.hpp>
#include <limits>
#include <set>

namespace foreview {
namespace {

ViewGeometry::ChartRecord chart_record(const Chart& chart) {
  ViewGeometry::ChartRecord record;
  record.origin = glm::vec2(chart.origin);
  record.size = glm::vec2(chart.size);
  record.valid = glm::vec2(glm::min(chart.inner + 2 * kChartGutter, chart.size));
  record.page = static_cast<float>(chart.page);
  record.group = static_cast<float>(chart.group);
  return record;
}

}  // namespace

ViewGeometry::ViewGeometry(const PolygonModel& model, const ChartLayout& layout)
    : part_centres(centres_of_parts(model)), part_is_backdrop(model.parts().size(), true) {
  assert(layout.charts.size() == model.polygons().size());
  std::set<std::array<std::uint32_t, 3>> edges_done;  // part, lower vertex, higher vertex
  for (std::size_t p = 0; p < model.polygons().size(); ++p) {
    const Polygon& polygon = model.polygons()[p];
    const Chart& chart = layout.charts[p];
    if (!polygon.is_backdrop) part_is_backdrop[polygon.part] = false;
    const auto corners = model.corners_of(p);
    const auto first = static_cast<std::uint32_t>(vertices.size());
    const auto count = static_cast<std::uint32_t>(corners.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      const glm::dvec3& point = model.vertices()[corners[i]];
      Vertex vertex;
      vertex.position = glm::vec3(point - part_centres[polygon.part]);
      vertex.texel = glm::vec2(chart.texel_from_part(point) - glm::dvec2(chart.origin));
      vertex.polygon = static_cast<std::uint32_t>(p);
      vertex.part = polygon.part;
      vertices.push_back(vertex);
      if (i >= 2) triangles.insert(triangles.end(), {first, first + i - 1, first + i});
      if (polygon.is_backdrop) continue;
      const std::uint32_t next = (i + 1) % count;
      const auto [low, high] = std::minmax(corners[i], corners[next]);
      if (edges_done.insert({polygon.part, low, high}).second) edges.insert(edges.end(), {first + i, first + next});
    }
    charts.push_back(chart_record(chart));
  }
}

CameraModel fit_camera(const CameraModel& camera, int width, int height) {
  const double scale = static_cast<double>(height) / camera.height;
  CameraModel fitted = camera.undistorted();
  fitted.width = width;
  fitted.height = height;
  fitted.focal_length = camera.focal_length * scale;
  fitted.principal_point = camera.principal_point * scale;
  fitted.principal_point.x += 0.5 * (width - camera.width * scale);
  return fitted;
}

}  // namespace foreview
