#include "foreview/gpu/batched/chart_tables.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vec4.hpp>

namespace foreview::batched {
namespace {

constexpr int kTipWidth = 2048;  // texels; wider than any chart at level 5

struct PatchOnGpu {
  glm::vec4 ball;
  glm::ivec4 rect, place;
  glm::vec4 extent;
};
struct ChartOnGpu {
  glm::ivec4 block, place;
};

template <typename T>
GlBuffer constant_buffer(const std::vector<T>& data) {
  GlBuffer buffer = GlBuffer::create();
  glNamedBufferStorage(buffer.id(), static_cast<GLsizeiptr>(std::max<std::size_t>(data.size(), 1) * sizeof(T)),
                       data.empty() ? nullptr : data.data(), 0);
  return buffer;
}

}  // namespace

ChartTables::ChartTables(const ChartLayout& layout, const ChartGeometry& geometry) {
  std::vector<PatchOnGpu> patches;
  for (const ChartGeometry::Patch& patch : geometry.patches()) {
    const ChartGroup& group = layout.groups[patch.chart];
    const int columns = patch_grid(group.size).x;
    patches.push_back(
        {glm::vec4(glm::vec3(patch.centre - geometry.part_centre(patch.part)), static_cast<float>(patch.radius)),
         glm::ivec4(patch.origin, patch.size), glm::ivec4(group.page, patch.chart, patch.part, columns),
         glm::vec4(static_cast<float>(patch.texels), 0, 0, 0)});
  }
  std::vector<ChartOnGpu> charts;
  std::vector<glm::uvec2> members;
  for (std::uint32_t i = 0; i < layout.groups.size(); ++i) {
    const ChartGroup& group = layout.groups[i];
    const ChartGeometry::Range& range = geometry.patches_of(i);
    charts.push_back({glm::ivec4(group.origin, group.size), glm::ivec4(group.page, range.first, range.count, 0)});
    for (const std::uint32_t polygon : layout.members_of(group)) members.emplace_back(polygon, i);
  }
  patches_ = constant_buffer(patches);
  charts_ = constant_buffer(charts);
  members_ = constant_buffer(members);
  lay_out_tip(layout);
}

void ChartTables::lay_out_tip(const ChartLayout& layout) {
  std::vector<glm::ivec4> rects;
  std::vector<glm::ivec2> sizes;
  int largest = 1;
  for (const ChartGroup& group : layout.groups) {
    rects.emplace_back(group.origin / 16, group.size / 16);
    sizes.push_back(group.size / 16);
    largest = std::max({largest, sizes.back().x, sizes.back().y});
  }
  // One level more than the pages have at the least, so that all tips lie in one texture.
  do {
    largest = (largest + 1) / 2;
    ++tip_level_;
    // Rows of charts side by side; there is no need to be tight.
    glm::ivec2 cursor(0), used(1);
    int row_height = 0;
    for (glm::ivec2& size : sizes) {
      size = (size + 1) / 2;
      if (cursor.x + size.x > kTipWidth) {
        cursor = {0, cursor.y + row_height};
        row_height = 0;
      }
      rects.emplace_back(cursor, size);
      cursor.x += size.x;
      row_height = std::max(row_height, size.y);
      used = glm::max(used, glm::ivec2(cursor.x, cursor.y + row_height));
    }
    tip_sizes_.push_back(used);
  } while (largest > 1);
  tip_rects_ = constant_buffer(rects);
}

void ChartTables::bind() const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, patches_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, charts_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 8, tip_rects_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 10, members_.id());
}

}  // namespace foreview::batched
