#include "foreview/gpu/batched/gatherer.h"

#include <algorithm>
#include <string>

#include "foreview/gpu/draw_tally.h"

namespace foreview::batched {
namespace {

constexpr GLenum kClipDistances = 5;
/// What a triangle costs beside its texels, in texels.
constexpr double kTexelsPerTriangle = 60;
double cost_in_texels(const ChartGeometry::Piece& piece) {
  return static_cast<double>(piece.texels) + kTexelsPerTriangle * piece.indices.count / 3;
}

}  // namespace

Gatherer::Gatherer(const ChartGeometry& geometry, const ChartLayout& layout)
    : geometry_(geometry),
      layout_(layout),
      one_sample_(make_program("batched_gather.vert.glsl", "batched_gather.frag.glsl", layer_defines())),
      footprint_(make_program("batched_gather.vert.glsl", "batched_gather.frag.glsl",
                              (std::string(layer_defines()) + "#define FOOTPRINT\n").c_str())),
      index_buffer_(GlBuffer::create()),
      linear_(make_clamped_sampler()) {
  glNamedBufferStorage(
      index_buffer_.id(),
      static_cast<GLsizeiptr>(std::max<std::size_t>(geometry.chart_indices().size(), 1) * sizeof(std::uint32_t)),
      nullptr, GL_DYNAMIC_STORAGE_BIT);
  patch_texels_.resize(geometry.patches().size());
  for (const ChartGeometry::Piece& piece : geometry.pieces()) {
    patch_texels_[piece.patch] += static_cast<float>(cost_in_texels(piece));
  }
}

std::size_t Gatherer::most_units(std::span<const std::uint32_t> touched) const {
  double texels = 0;
  for (const std::uint32_t patch : touched) texels += static_cast<double>(patch_texels_[patch]);
  return static_cast<std::size_t>(texels / kTexelsPerUnit) + 1;
}

void Gatherer::list(const PictureSetup& setup, const std::vector<bool>& is_late, const CameraModel& camera,
                    const std::optional<std::span<const std::uint32_t>>& touched) {
  texels_ = 0;
  queries_used_ = 0;
  indices_.clear();
  unit_ends_.clear();
  draws_ = {};
  if (camera.width < 2 || camera.height < 2) return;
  if (touched) {
    is_touched_.assign(geometry_.patches().size(), false);
    for (const std::uint32_t patch : *touched) is_touched_[patch] = true;
  }
  const std::vector<std::uint32_t>& all = geometry_.chart_indices();
  const auto append = [&](const ChartGeometry::Range& range) {
    const auto begin = all.begin() + range.first;
    indices_.insert(indices_.end(), begin, begin + range.count);
  };
  double texels_in_unit = 0;
  const auto append_touched = [&](const ChartGeometry::Range& pieces) {
    for (std::uint32_t i = pieces.first; i < pieces.first + pieces.count; ++i) {
      const ChartGeometry::Piece& piece = geometry_.pieces()[i];
      if (!is_touched_[piece.patch]) continue;
      append(piece.indices);
      texels_in_unit += cost_in_texels(piece);
      if (texels_in_unit < kTexelsPerUnit) continue;
      unit_ends_.push_back(indices_.size());
      texels_in_unit = 0;
    }
  };
  // A polygon's own texels win over others' gutter: so gutters come first, or last where only holes are filled. Close
  // polygons take several samples.
  const auto add = [&](bool late, bool close, bool own) {
    for (const auto& [polygon, is_close] : setup.visible()) {
      if (is_late[layout_.charts[polygon].group] != late || is_close != close) continue;
      if (own) texels_ += static_cast<double>(geometry_.texels(polygon));
      if (touched) {
        append_touched(own ? geometry_.own_pieces(polygon) : geometry_.gutter_pieces(polygon));
      } else {
        append(own ? geometry_.own_triangles(polygon) : geometry_.gutter_triangles(polygon));
      }
    }
  };
  std::size_t draw_count = 0;
  for (const bool late : {false, true}) {
    add(late, false, late);
    draws_[draw_count++] = {late, false, indices_.size()};
    add(late, true, late);
    add(late, true, !late);
    draws_[draw_count++] = {late, true, indices_.size()};
    add(late, false, !late);
    draws_[draw_count++] = {late, false, indices_.size()};
  }
  if (!indices_.empty() && (unit_ends_.empty() || unit_ends_.back() < indices_.size())) {
    unit_ends_.push_back(indices_.size());
  }
  glNamedBufferSubData(index_buffer_.id(), 0, static_cast<GLsizeiptr>(indices_.size() * sizeof(std::uint32_t)),
                       indices_.data());
}

void Gatherer::gather(const CameraModel& camera, double near_plane, GLuint undistorted, GLuint exposure,
                      const PictureBounds& bounds, const PatchLists& patches, const LayerTargets& into,
                      const Run& units) {
  if (units.count == 0) return;
  GLint room_width = 0, room_height = 0;
  glGetTextureLevelParameteriv(undistorted, 0, GL_TEXTURE_WIDTH, &room_width);
  glGetTextureLevelParameteriv(undistorted, 0, GL_TEXTURE_HEIGHT, &room_height);
  glBindTextureUnit(0, undistorted);
  glBindSampler(0, linear_.id());
  glBindTextureUnit(1, bounds.cells());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, exposure);
  glVertexArrayElementBuffer(geometry_.vertex_array(), index_buffer_.id());
  glBindVertexArray(geometry_.vertex_array());
  for (GLenum i = 0; i < kClipDistances; ++i) glEnable(GL_CLIP_DISTANCE0 + i);
  glViewport(0, 0, layout_.page_size, layout_.page_size);
  if (counting_) {
    if (queries_used_ == taken_.size()) taken_.push_back(GlSamplesQuery::create());
    glBeginQuery(GL_SAMPLES_PASSED, taken_[queries_used_++].id());
  }
  bool begins_pass = true;
  std::size_t first = units.first == 0 ? 0 : unit_ends_[units.first - 1];
  const std::size_t end = unit_ends_[units.first + units.count - 1];
  for (const Draw& draw : draws_) {
    if (draw.end <= first || first >= end) continue;
    const std::size_t count = std::min(draw.end, end) - first;
    glUseProgram(draw.close ? footprint_.id() : one_sample_.id());
    glUniform2f(0, static_cast<float>(camera.focal_length.x), static_cast<float>(camera.focal_length.y));
    glUniform2f(1, static_cast<float>(camera.principal_point.x), static_cast<float>(camera.principal_point.y));
    glUniform2f(2, static_cast<float>(camera.width), static_cast<float>(camera.height));
    glUniform1f(3, static_cast<float>(near_plane));
    glUniform1f(4, 2.0F / static_cast<float>(layout_.page_size));
    glUniform2i(5, camera.width - 2, camera.height - 2);
    glUniform2f(6, 1.0F / static_cast<float>(room_width), 1.0F / static_cast<float>(room_height));
    glUniform1ui(7, patches.picture_number());
    if (draw.late) {
      glEnable(GL_BLEND);
      glBlendFuncSeparate(GL_ONE_MINUS_DST_ALPHA, GL_DST_ALPHA, GL_ONE, GL_ONE);
    }
    for (std::size_t page = 0; page < into.size(); ++page) {
      glUniform1i(8, static_cast<GLint>(page));
      glBindFramebuffer(GL_DRAW_FRAMEBUFFER, into[page].id());
      // An offset that GL takes as a pointer. NOLINTBEGIN(performance-no-int-to-ptr)
      glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
      // NOLINTEND(performance-no-int-to-ptr)
      // Where all pages are one target, the next class belongs to the same pass.
      count_draw(begins_pass || into.size() > 1);
      begins_pass = false;
    }
    first += count;
  }
  if (counting_) glEndQuery(GL_SAMPLES_PASSED);
  glDisable(GL_BLEND);
  for (GLenum i = 0; i < kClipDistances; ++i) glDisable(GL_CLIP_DISTANCE0 + i);
  glBindSampler(0, 0);
  glBindVertexArray(0);
}

std::size_t Gatherer::observed() const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < queries_used_; ++i) {
    GLuint64 samples = 0;
    glGetQueryObjectui64v(taken_[i].id(), GL_QUERY_RESULT, &samples);
    sum += static_cast<std::size_t>(samples);
  }
  return sum;
}

}  // namespace foreview::batched
