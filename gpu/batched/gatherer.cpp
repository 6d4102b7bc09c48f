#include "foreview/gpu/batched/gatherer.h"

#include <algorithm>
#include <array>
#include <string>

#include "foreview/gpu/draw_tally.h"

namespace foreview::batched {
namespace {

constexpr GLenum kClipDistances = 5;

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
}

void Gatherer::gather(const PictureSetup& setup, const std::vector<bool>& is_late, const CameraModel& camera,
                      double near_plane, GLuint undistorted, GLuint exposure, const PictureBounds& bounds,
                      const PatchLists& patches, const LayerTargets& into) {
  texels_ = 0;
  counted_ = false;
  if (camera.width < 2 || camera.height < 2) return;
  // A polygon's own texels win over others' gutter: so gutters come first, or last where only holes are filled. Close
  // polygons take several samples.
  indices_.clear();
  const std::vector<PictureSetup::Visible>& visible = setup.visible();
  const auto add = [&](bool late, bool close, bool own) {
    for (const auto& [polygon, is_close] : visible) {
      if (is_late[layout_.charts[polygon].group] != late || is_close != close) continue;
      const ChartGeometry::Range& range = own ? geometry_.own_triangles(polygon) : geometry_.gutter_triangles(polygon);
      const auto begin = geometry_.chart_indices().begin() + range.first;
      indices_.insert(indices_.end(), begin, begin + range.count);
      if (own) texels_ += static_cast<double>(geometry_.texels(polygon));
    }
  };
  struct Draw {
    bool late = false, close = false;
    std::size_t end = 0;
  };
  std::array<Draw, 6> draws;
  std::size_t draw_count = 0;
  for (const bool late : {false, true}) {
    add(late, false, late);
    draws[draw_count++] = {late, false, indices_.size()};
    add(late, true, late);
    add(late, true, !late);
    draws[draw_count++] = {late, true, indices_.size()};
    add(late, false, !late);
    draws[draw_count++] = {late, false, indices_.size()};
  }
  glNamedBufferSubData(index_buffer_.id(), 0, static_cast<GLsizeiptr>(indices_.size() * sizeof(std::uint32_t)),
                       indices_.data());
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
    if (taken_.id() == 0) taken_ = GlSamplesQuery::create();
    glBeginQuery(GL_SAMPLES_PASSED, taken_.id());
    counted_ = true;
  }
  bool begins_pass = true;
  std::size_t first = 0;
  for (const Draw& draw : draws) {
    const std::size_t count = draw.end - first;
    if (count == 0) continue;
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
    first = draw.end;
  }
  if (counting_) glEndQuery(GL_SAMPLES_PASSED);
  glDisable(GL_BLEND);
  for (GLenum i = 0; i < kClipDistances; ++i) glDisable(GL_CLIP_DISTANCE0 + i);
  glBindSampler(0, 0);
  glBindVertexArray(0);
}

std::size_t Gatherer::observed() const {
  if (!counted_) return 0;
  GLuint64 samples = 0;
  glGetQueryObjectui64v(taken_.id(), GL_QUERY_RESULT, &samples);
  return static_cast<std::size_t>(samples);
}

}  // namespace foreview::batched
