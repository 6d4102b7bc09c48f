#include "foreview/gpu/batched/patch_lists.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "foreview/gpu/draw_tally.h"
#include "foreview/scene/errors.h"

namespace foreview::batched {
namespace {

constexpr GLuint kVerticesPerPatch = 6;

GlBuffer make_buffer(std::size_t bytes) {
  GlBuffer buffer = GlBuffer::create();
  glNamedBufferStorage(buffer.id(), static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, 16)), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  return buffer;
}

GLuint groups_of_64(std::size_t invocations) {
  return static_cast<GLuint>((invocations + 63) / 64);
}

}  // namespace

PatchLists::PatchLists(const ChartGeometry& geometry, const ChartTables& tables, int page_size)
    : geometry_(geometry),
      tables_(tables),
      page_size_(page_size),
      touch_(make_compute_program("batched_touch.comp.glsl")),
      renew_(make_compute_program("batched_renew.comp.glsl")),
      flags_(make_buffer(geometry.patches().size() * sizeof(GLuint))),
      commands_(make_buffer(sizeof(Commands))),
      lists_(make_buffer(3 * geometry.patches().size() * sizeof(GLuint))),
      candidate_buffer_(make_buffer(geometry.patches().size() * sizeof(GLuint))),
      slack_buffer_(
          make_buffer((geometry.patches().empty() ? 0 : geometry.patches().back().chart + 1) * sizeof(GLfloat))),
      no_vertices_(GlVertexArray::create()) {
  clear();
}

void PatchLists::clear() {
  picture_number_ = 0;
  glClearNamedBufferData(flags_.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
}

void PatchLists::bind() const {
  tables_.bind();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, flags_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, commands_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, lists_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, candidate_buffer_.id());
}

void PatchLists::set_commands(const Commands& commands) {
  glNamedBufferSubData(commands_.id(), 0, sizeof commands, &commands);
}

void PatchLists::begin(const PictureSetup& setup, const std::vector<std::uint32_t>& charts, const CameraModel& camera) {
  ++picture_number_;
  candidates_.clear();
  const bool has_cells = camera.width > 1 && camera.height > 1;
  for (const std::uint32_t chart : charts) {
    if (!has_cells) break;
    const ChartGeometry::Range& range = geometry_.patches_of(chart);
    for (std::uint32_t i = 0; i < range.count; ++i) candidates_.push_back(range.first + i);
  }
  glNamedBufferSubData(candidate_buffer_.id(), 0, static_cast<GLsizeiptr>(candidates_.size() * sizeof(GLuint)),
                       candidates_.data());
  glNamedBufferSubData(slack_buffer_.id(), 0, static_cast<GLsizeiptr>(setup.slacks().size() * sizeof(GLfloat)),
                       setup.slacks().data());
  set_commands({});
}

void PatchLists::dispatch_candidates(const Run& candidates) const {
  glUniform1ui(4, static_cast<GLuint>(candidates.first + candidates.count));
  glUniform1ui(5, picture_number_);
  glUniform1ui(6, static_cast<GLuint>(geometry_.patches().size()));
  glUniform1ui(7, static_cast<GLuint>(candidates.first));
  glDispatchCompute(groups_of_64(candidates.count), 1, 1);
  count_draw();
}

void PatchLists::touch(const CameraModel& camera, double near_plane, const PictureBounds& bounds,
                       const Run& candidates) {
  if (candidates.count == 0) return;
  bind();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 11, slack_buffer_.id());
  glUseProgram(touch_.id());
  glUniform2f(0, static_cast<float>(camera.focal_length.x), static_cast<float>(camera.focal_length.y));
  glUniform2f(1, static_cast<float>(camera.principal_point.x), static_cast<float>(camera.principal_point.y));
  glUniform2f(2, static_cast<float>(camera.width), static_cast<float>(camera.height));
  glUniform1f(3, static_cast<float>(near_plane));
  glBindTextureUnit(0, bounds.coarse_cells());
  dispatch_candidates(candidates);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void PatchLists::touch_all() {
  ++picture_number_;
  candidates_.resize(geometry_.patches().size());
  std::iota(candidates_.begin(), candidates_.end(), 0U);
  glNamedBufferSubData(lists_.id(), 0, static_cast<GLsizeiptr>(candidates_.size() * sizeof(GLuint)),
                       candidates_.data());
  Commands commands;
  commands.draws[touched].count = static_cast<GLuint>(candidates_.size()) * kVerticesPerPatch;
  commands.touched_groups[0] = (static_cast<GLuint>(candidates_.size()) + kPatchesPerGroup - 1) / kPatchesPerGroup;
  set_commands(commands);
  bind();
}

void PatchLists::renew(GLuint filled, GLuint pulled, GLuint pages, const Run& candidates) {
  if (candidates.count == 0) return;
  bind();
  glUseProgram(renew_.id());
  glBindTextureUnit(0, filled);
  glBindTextureUnit(1, pulled);
  glBindImageTexture(0, pages, kChartLevels - 1, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
  dispatch_candidates(candidates);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                  GL_FRAMEBUFFER_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void PatchLists::draw(List list, int level, const LayerTargets& into, const std::optional<Run>& patches) {
  const int size = page_size_ >> level;
  glBindVertexArray(no_vertices_.id());
  glViewport(0, 0, size, size);
  glUniform1ui(0, list);
  glUniform1ui(1, static_cast<GLuint>(geometry_.patches().size()));
  glUniform1i(2, level);
  glUniform1f(3, 2.0F / static_cast<float>(size));
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.id());
  for (std::size_t page = 0; page < into.size(); ++page) {
    glUniform1i(4, static_cast<GLint>(page));
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, into[page].id());
    if (patches) {
      glDrawArrays(GL_TRIANGLES, static_cast<GLint>(patches->first * kVerticesPerPatch),
                   static_cast<GLsizei>(patches->count * kVerticesPerPatch));
    } else {
      // An offset that GL takes as a pointer. NOLINTBEGIN(performance-no-int-to-ptr)
      glDrawArraysIndirect(GL_TRIANGLES, reinterpret_cast<const void*>(list * sizeof(DrawCommand)));
      // NOLINTEND(performance-no-int-to-ptr)
    }
    count_draw();
  }
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

void PatchLists::dispatch_touched(const std::optional<Run>& groups) const {
  glUniform1ui(10, groups ? static_cast<GLuint>(groups->first) : 0);
  if (groups) {
    glDispatchCompute(static_cast<GLuint>(groups->count), 1, 1);
  } else {
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, commands_.id());
    glDispatchComputeIndirect(offsetof(Commands, touched_groups));
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, 0);
  }
  count_draw();
}

void PatchLists::fetch() {
  if (fetched_bytes_ == nullptr) {
    fetched_ = GlBuffer::create();
    const auto bytes = static_cast<GLsizeiptr>(sizeof(Commands) + geometry_.patches().size() * sizeof(GLuint));
    constexpr GLbitfield kMapped = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    glNamedBufferStorage(fetched_.id(), bytes, nullptr, kMapped);
    fetched_bytes_ = static_cast<const std::byte*>(glMapNamedBufferRange(fetched_.id(), 0, bytes, kMapped));
    if (fetched_bytes_ == nullptr) throw GraphicsError("the graphics driver does not map a buffer for reading");
  }
  glCopyNamedBufferSubData(commands_.id(), fetched_.id(), 0, 0, sizeof(Commands));
  if (candidates_.empty()) return;
  glCopyNamedBufferSubData(lists_.id(), fetched_.id(), 0, sizeof(Commands),
                           static_cast<GLsizeiptr>(candidates_.size() * sizeof(GLuint)));
}

const PatchLists::Commands& PatchLists::fetched_commands() const {
  return *reinterpret_cast<const Commands*>(fetched_bytes_);
}

std::array<std::size_t, 3> PatchLists::fetched_lengths() const {
  return lengths_of(fetched_commands().draws);
}

std::span<const std::uint32_t> PatchLists::fetched_touched() const {
  return {reinterpret_cast<const std::uint32_t*>(fetched_bytes_ + sizeof(Commands)), fetched_lengths()[touched]};
}

std::array<std::size_t, 3> PatchLists::lengths_of(const std::array<DrawCommand, 3>& commands) {
  std::array<std::size_t, 3> lengths{};
  for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] = commands[i].count / kVerticesPerPatch;
  return lengths;
}

std::array<std::size_t, 3> PatchLists::lengths() const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::array<DrawCommand, 3> commands;
  glGetNamedBufferSubData(commands_.id(), 0, sizeof commands, commands.data());
  return lengths_of(commands);
}

}  // namespace foreview::batched
