#include "foreview/gpu/batched/chart_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview::batched {
namespace {

constexpr double kLeastLength = 1e-9;  // texels

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

double area(const std::vector<glm::dvec2>& shape) {
  double twice = 0;
  for (std::size_t i = 2; i < shape.size(); ++i) twice += cross(shape[i - 1] - shape[0], shape[i] - shape[0]);
  return twice / 2;
}

/// The part of a convex shape where sign * (coordinate - border) >= 0 along an axis.
std::vector<glm::dvec2> cut(const std::vector<glm::dvec2>& shape, int axis, double border, double sign) {
  std::vector<glm::dvec2> result;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const glm::dvec2 &from = shape[i], &to = shape[(i + 1) % shape.size()];
    const double a = sign * (from[axis] - border), b = sign * (to[axis] - border);
    if (a >= 0) result.push_back(from);
    if ((a >= 0) == (b >= 0)) continue;
    glm::dvec2 crossing = from + (to - from) * (a / (a - b));
    crossing[axis] = border;
    result.push_back(crossing);
  }
  return result;
}

/// The gutter along a polygon's edges on its chart's outline: a strip along each, and a wedge where two of them meet.
std::vector<std::vector<glm::dvec2>> gutter_shapes(const std::vector<glm::dvec2>& corners,
                                                   const std::vector<bool>& is_outline) {
  std::vector<std::vector<glm::dvec2>> shapes;
  const std::size_t count = corners.size();
  const double side = area(corners) >= 0 ? 1 : -1;
  std::vector<glm::dvec2> outwards(count, glm::dvec2(0));
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec2 along = corners[(i + 1) % count] - corners[i];
    const double length = glm::length(along);
    if (is_outline[i] && length > kLeastLength) {
      outwards[i] = side * glm::dvec2(along.y, -along.x) / length * static_cast<double>(kChartGutter);
    }
  }
  const auto is_strip = [&](std::size_t i) { return outwards[i] != glm::dvec2(0); };
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_strip(i)) continue;
    const glm::dvec2 &a = corners[i], &b = corners[(i + 1) % count];
    shapes.push_back({a, a + outwards[i], b + outwards[i], b});
    const std::size_t next = (i + 1) % count;
    if (!is_strip(next)) continue;
    // Two steps, so that the wedge reaches nearly as far as the strips.
    const glm::dvec2 between = outwards[i] + outwards[next];
    const double length = glm::length(between);
    if (length <= kLeastLength) continue;
    shapes.push_back(
        {b, b + outwards[i], b + between / length * static_cast<double>(kChartGutter), b + outwards[next]});
  }
  return shapes;
}

}  // namespace

ChartGeometry::ChartGeometry(const PolygonModel& model, const ChartLayout& layout)
    : part_centres_(centres_of_parts(model)), vertex_array_(GlVertexArray::create()), vertices_(GlBuffer::create()) {
  add_patches(layout);
  Making making;
  making.boxes.resize(patches_.size());
  std::vector<Vertex>& vertices = making.vertices;
  for (std::uint32_t i = 0; i < model.polygons().size(); ++i) {
    const Polygon& polygon = model.polygons()[i];
    const Chart& chart = layout.charts[i];
    std::vector<glm::dvec2> corners;
    std::vector<bool> is_outline;
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t k = 0; k < polygon.corner_count; ++k) {
      const glm::dvec3& corner = model.corner(i, k);
      corners.push_back(chart.texel_from_part(corner));
      is_outline.push_back(layout.outline[polygon.first_corner + k]);
      vertices.push_back({glm::vec3(corner - part_centres_[polygon.part]), i, polygon.part, 0, {}});
    }
    corners_.push_back({first, polygon.corner_count});
    scene_index_count_ += 3 * (std::size_t{polygon.corner_count} - 2);
    double texels = std::abs(area(corners));
    Range& own = own_.emplace_back();
    own.first = static_cast<std::uint32_t>(chart_indices_.size());
    const auto first_piece = static_cast<std::uint32_t>(pieces_.size());
    add_shape(making, corners, i, chart, polygon.part);
    own.count = static_cast<std::uint32_t>(chart_indices_.size()) - own.first;
    const auto first_of_gutter = static_cast<std::uint32_t>(pieces_.size());
    own_pieces_.push_back({first_piece, first_of_gutter - first_piece});
    Range& gutter = gutter_.emplace_back();
    gutter.first = static_cast<std::uint32_t>(chart_indices_.size());
    for (const auto& shape : gutter_shapes(corners, is_outline)) {
      texels += std::abs(area(shape));
      add_shape(making, shape, i, chart, polygon.part);
    }
    gutter.count = static_cast<std::uint32_t>(chart_indices_.size()) - gutter.first;
    gutter_pieces_.push_back({first_of_gutter, static_cast<std::uint32_t>(pieces_.size()) - first_of_gutter});
    texels_.push_back(static_cast<float>(texels));
  }
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const Box& box = making.boxes[i];
    if (box.lower.x > box.upper.x) continue;
    patches_[i].centre = 0.5 * (box.lower + box.upper);
    patches_[i].radius = 0.5 * glm::distance(box.lower, box.upper);
  }
  glNamedBufferStorage(vertices_.id(), static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(), 0);
  const GLuint array = vertex_array_.id();
  glVertexArrayVertexBuffer(array, 0, vertices_.id(), 0, sizeof(Vertex));
  for (GLuint attribute = 0; attribute < 5; ++attribute) {
    glEnableVertexArrayAttrib(array, attribute);
    glVertexArrayAttribBinding(array, attribute, 0);
  }
  glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
  glVertexArrayAttribIFormat(array, 1, 1, GL_UNSIGNED_INT, offsetof(Vertex, polygon));
  glVertexArrayAttribIFormat(array, 2, 1, GL_UNSIGNED_INT, offsetof(Vertex, part));
  glVertexArrayAttribFormat(array, 3, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, texel));
  glVertexArrayAttribIFormat(array, 4, 1, GL_UNSIGNED_INT, offsetof(Vertex, patch));
}

void ChartGeometry::add_patches(const ChartLayout& layout) {
  for (std::uint32_t chart = 0; chart < layout.groups.size(); ++chart) {
    const ChartGroup& group = layout.groups[chart];
    Range& range = patches_of_.emplace_back();
    range.first = static_cast<std::uint32_t>(patches_.size());
    for (int y = 0; y < group.size.y; y += kPatchTexels) {
      for (int x = 0; x < group.size.x; x += kPatchTexels) {
        Patch& patch = patches_.emplace_back();
        patch.chart = chart;
        patch.origin = group.origin + glm::ivec2(x, y);
        patch.size = glm::min(glm::ivec2(kPatchTexels), group.size - glm::ivec2(x, y));
      }
    }
    range.count = static_cast<std::uint32_t>(patches_.size()) - range.first;
  }
}

void ChartGeometry::add_shape(Making& making, const std::vector<glm::dvec2>& shape, std::uint32_t polygon,
                              const Chart& chart, std::uint32_t part) {
  glm::dvec2 lower(1e300), upper(-1e300);
  for (const glm::dvec2& p : shape) {
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
  }
  const glm::ivec2 cells = patch_grid(chart.size);
  const auto cell_of = [&](const glm::dvec2& p) {
    return glm::clamp(glm::ivec2(glm::floor((p - glm::dvec2(chart.origin)) / static_cast<double>(kPatchTexels))),
                      glm::ivec2(0), cells - 1);
  };
  const glm::ivec2 from = cell_of(lower), to = cell_of(upper);
  for (int row = from.y; row <= to.y; ++row) {
    std::vector<glm::dvec2> band = shape;
    if (row > from.y) band = cut(band, 1, chart.origin.y + row * kPatchTexels, 1);
    if (row < to.y) band = cut(band, 1, chart.origin.y + (row + 1) * kPatchTexels, -1);
    for (int column = from.x; column <= to.x; ++column) {
      std::vector<glm::dvec2> piece = band;
      if (column > from.x) piece = cut(piece, 0, chart.origin.x + column * kPatchTexels, 1);
      if (column < to.x) piece = cut(piece, 0, chart.origin.x + (column + 1) * kPatchTexels, -1);
      if (piece.size() < 3 || !(std::abs(area(piece)) > kLeastLength)) continue;
      const std::uint32_t patch_index =
          patches_of_[chart.group].first + static_cast<std::uint32_t>(row * cells.x + column);
      patches_[patch_index].part = part;
      patches_[patch_index].texels += std::abs(area(piece));
      Box& box = making.boxes[patch_index];
      const auto first = static_cast<std::uint32_t>(making.vertices.size());
      pieces_.push_back(
          {patch_index,
           {static_cast<std::uint32_t>(chart_indices_.size()), 3 * (static_cast<std::uint32_t>(piece.size()) - 2)},
           static_cast<float>(std::abs(area(piece)))});
      for (std::uint32_t k = 0; k < piece.size(); ++k) {
        const glm::dvec3 position = chart.part_from_texel(piece[k]);
        box.lower = glm::min(box.lower, position);
        box.upper = glm::max(box.upper, position);
        making.vertices.push_back(
            {glm::vec3(position - part_centres_[part]), polygon, part, patch_index, glm::vec2(piece[k])});
        if (k >= 2) chart_indices_.insert(chart_indices_.end(), {first, first + k - 1, first + k});
      }
    }
  }
}

}  // namespace foreview::batched
