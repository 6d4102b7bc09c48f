#include "foreview/viewer/model_buffers.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <glm/ext/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

namespace foreview {
namespace {

template <class T>
GlBuffer make_buffer(const std::vector<T>& content, GLbitfield flags = 0) {
  GlBuffer buffer = GlBuffer::create();
  // A buffer cannot be empty; nothing is ever read from this stand-in.
  static constexpr std::array<char, 64> kNothing{};
  const auto bytes = static_cast<GLsizeiptr>(content.size() * sizeof(T));
  glNamedBufferStorage(buffer.id(), bytes > 0 ? bytes : 64,
                       bytes > 0 ? static_cast<const void*>(content.data()) : kNothing.data(), flags);
  return buffer;
}

void set_attribute(GLuint vao, GLuint index, GLint components, std::size_t offset, bool integer) {
  glEnableVertexArrayAttrib(vao, index);
  if (integer) {
    glVertexArrayAttribIFormat(vao, index, components, GL_UNSIGNED_INT, static_cast<GLuint>(offset));
  } else {
    glVertexArrayAttribFormat(vao, index, components, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
  }
  glVertexArrayAttribBinding(vao, index, 0);
}

}  // namespace

ModelBuffers::Placement::Placement(std::size_t parts)
    : buffer_(make_buffer(std::vector<glm::mat4>(parts), GL_DYNAMIC_STORAGE_BIT)), matrices_(parts) {}

ModelBuffers::ModelBuffers(const PolygonModel& model, const ChartLayout& layout)
    : geometry_(model, layout),
      order_(geometry_),
      vertices_(make_buffer(geometry_.vertices)),
      triangles_(make_buffer(geometry_.triangles)),
      sorted_triangles_(make_buffer(geometry_.triangles, GL_DYNAMIC_STORAGE_BIT)),
      edges_(make_buffer(geometry_.edges)),
      charts_(make_buffer(geometry_.charts)),
      vao_(GlVertexArray::create()) {
  glVertexArrayVertexBuffer(vao_.id(), 0, vertices_.id(), 0, sizeof(ViewGeometry::Vertex));
  set_attribute(vao_.id(), 0, 3, offsetof(ViewGeometry::Vertex, position), false);
  set_attribute(vao_.id(), 1, 2, offsetof(ViewGeometry::Vertex, texel), false);
  set_attribute(vao_.id(), 2, 1, offsetof(ViewGeometry::Vertex, polygon), true);
  set_attribute(vao_.id(), 3, 1, offsetof(ViewGeometry::Vertex, part), true);
}

void ModelBuffers::place(Placement& placement, const CameraModel& camera, const Pose& world_from_camera,
                         std::span<const Pose> world_from_part, double near_plane, bool flip) const {
  assert(world_from_part.size() == placement.matrices_.size());
  glm::dmat4 clip_from_camera = camera.clip_from_camera(near_plane);
  if (flip) {
    clip_from_camera = glm::scale(glm::dmat4(1.0), glm::dvec3(1, -1, 1)) * clip_from_camera;
  }
  const Pose camera_from_world = world_from_camera.inverse();
  for (std::size_t i = 0; i < world_from_part.size(); ++i) {
    const glm::dmat4 part_from_centre = glm::translate(glm::dmat4(1.0), geometry_.part_centres[i]);
    placement.matrices_[i] = clip_from_camera * (camera_from_world * world_from_part[i]).matrix() * part_from_centre;
  }
  glNamedBufferSubData(placement.buffer_.id(), 0,
                       static_cast<GLsizeiptr>(placement.matrices_.size() * sizeof(glm::mat4)),
                       placement.matrices_.data());
}

void ModelBuffers::bind() const {
  glBindVertexArray(vao_.id());
}

void ModelBuffers::draw_triangles(bool sorted) const {
  glVertexArrayElementBuffer(vao_.id(), sorted ? sorted_triangles_.id() : triangles_.id());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(geometry_.triangles.size()), GL_UNSIGNED_INT, nullptr);
}

void ModelBuffers::sort(const Pose& world_from_camera, std::span<const Pose> world_from_part) {
  const std::span<const std::uint32_t> order = order_.front_to_back(world_from_camera, world_from_part);
  glNamedBufferSubData(sorted_triangles_.id(), 0, static_cast<GLsizeiptr>(order.size_bytes()), order.data());
}

void ModelBuffers::draw_edges() const {
  glVertexArrayElementBuffer(vao_.id(), edges_.id());
  glDrawElements(GL_LINES, static_cast<GLsizei>(geometry_.edges.size()), GL_UNSIGNED_INT, nullptr);
}

}  // namespace foreview
