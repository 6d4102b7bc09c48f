#include "foreview/viewer/frame_painter.h"

#include <cstddef>

namespace foreview {
namespace {

constexpr float kSolid = 0, kText = 1, kAgeScale = 2, kDensityScale = 3;  // view_paint.frag.glsl

void set_attribute(GLuint vao, GLuint index, GLint components, std::size_t offset) {
  glEnableVertexArrayAttrib(vao, index);
  glVertexArrayAttribFormat(vao, index, components, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
  glVertexArrayAttribBinding(vao, index, 0);
}

}  // namespace

FramePainter::FramePainter()
    : program_(make_program("view_paint.vert.glsl", "view_paint.frag.glsl")),
      buffer_(GlBuffer::create()),
      vao_(GlVertexArray::create()),
      sampler_(make_clamped_sampler(GL_LINEAR_MIPMAP_LINEAR)) {
  glNamedBufferStorage(buffer_.id(), kMostVertices * sizeof(Vertex), nullptr, GL_DYNAMIC_STORAGE_BIT);
  glVertexArrayVertexBuffer(vao_.id(), 0, buffer_.id(), 0, sizeof(Vertex));
  set_attribute(vao_.id(), 0, 2, offsetof(Vertex, position));
  set_attribute(vao_.id(), 1, 2, offsetof(Vertex, place));
  set_attribute(vao_.id(), 2, 4, offsetof(Vertex, colour));
  set_attribute(vao_.id(), 3, 1, offsetof(Vertex, kind));
  vertices_.reserve(kMostVertices);
}

void FramePainter::quad(const glm::vec2& first, const glm::vec2& last, const glm::vec2& place_first,
                        const glm::vec2& place_last, const glm::vec4& colour, float kind) {
  if (vertices_.size() + 6 > kMostVertices) return;
  const Vertex upper_left{first, place_first, colour, kind}, lower_right{last, place_last, colour, kind};
  const Vertex upper_right{{last.x, first.y}, {place_last.x, place_first.y}, colour, kind};
  const Vertex lower_left{{first.x, last.y}, {place_first.x, place_last.y}, colour, kind};
  for (const Vertex& vertex : {upper_left, lower_left, lower_right, upper_left, lower_right, upper_right}) {
    vertices_.push_back(vertex);
  }
}

void FramePainter::rectangle(const glm::vec2& corner, const glm::vec2& size, const glm::vec4& colour) {
  quad(corner, corner + size, {}, {}, colour, kSolid);
}

void FramePainter::text(const glm::vec2& corner, float height, std::string_view text, const glm::vec4& colour) {
  glm::vec2 at = corner;
  at.x -= height * 0.125F;  // the margin of a cell
  for (const char character : text) {
    const GlyphAtlas::Glyph& glyph = atlas_.glyph(character);
    quad(at, at + height * glm::vec2(glyph.width, 1), glyph.first, glyph.last, colour, kText);
    at.x += height * glyph.advance;
  }
}

void FramePainter::scale(const glm::vec2& corner, const glm::vec2& size, Scale scale) {
  quad(corner, corner + size, {0, 0}, {1, 0}, {}, scale == Scale::age ? kAgeScale : kDensityScale);
}

void FramePainter::flush(GLuint framebuffer, int width, int height) {
  if (vertices_.empty()) return;
  glNamedBufferSubData(buffer_.id(), 0, static_cast<GLsizeiptr>(vertices_.size() * sizeof(Vertex)), vertices_.data());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glUseProgram(program_.id());
  glUniform2f(0, static_cast<float>(width), static_cast<float>(height));
  glBindVertexArray(vao_.id());
  glBindTextureUnit(0, atlas_.texture());
  glBindSampler(0, sampler_.id());
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_.size()));
  glBindSampler(0, 0);
  glBindVertexArray(0);
  glUseProgram(0);
  glDisable(GL_BLEND);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  vertices_.clear();
}

}  // namespace foreview
