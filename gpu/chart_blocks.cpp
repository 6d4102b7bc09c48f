#include "foreview/gpu/chart_blocks.h"

#include <algorithm>

#include "foreview/gpu/draw_tally.h"

namespace foreview {
namespace {

/// Fewest that GL guarantees along an axis of a dispatch is 65535.
constexpr std::size_t kGroupsPerRow = 1024, kGroupsPerDispatch = kGroupsPerRow * 1024;

}  // namespace

ChartBlocks::ChartBlocks(const ChartLayout& layout) : layout_(layout), buffer_(GlBuffer::create()) {
  std::size_t count = 0;
  for (const ChartGroup& group : layout.groups) {
    const glm::ivec2 size = group.size / kChartAlignment;
    count += static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  }
  blocks_.reserve(count);
  glNamedBufferStorage(buffer_.id(), static_cast<GLsizeiptr>(std::max<std::size_t>(count, 1) * sizeof(std::uint32_t)),
                       nullptr, GL_DYNAMIC_STORAGE_BIT);
}

void ChartBlocks::list(const std::vector<std::uint32_t>& groups) {
  blocks_.clear();
  for (const std::uint32_t index : groups) {
    const ChartGroup& group = layout_.groups[index];
    const glm::ivec2 first = group.origin / kChartAlignment, end = first + group.size / kChartAlignment;
    for (int y = first.y; y < end.y; ++y) {
      for (int x = first.x; x < end.x; ++x) {
        blocks_.push_back(static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 10 | group.page << 20);
      }
    }
  }
  glNamedBufferSubData(buffer_.id(), 0, static_cast<GLsizeiptr>(blocks_.size() * sizeof(std::uint32_t)),
                       blocks_.data());
}

void ChartBlocks::dispatch(std::size_t begin, std::size_t size) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer_.id());
  const std::size_t end = begin + size;
  for (std::size_t first = begin; first < end; first += kGroupsPerDispatch) {
    const std::size_t count = std::min(kGroupsPerDispatch, end - first);
    const std::size_t columns = std::min(count, kGroupsPerRow);
    glUniform1ui(0, static_cast<GLuint>(first));
    glUniform1ui(1, static_cast<GLuint>(count));
    count_draw();
    glDispatchCompute(static_cast<GLuint>(columns), static_cast<GLuint>((count + columns - 1) / columns), 1);
  }
}

}  // namespace foreview
