#include "foreview/gpu/per_polygon/depth_owner_pass.h"

#include <algorithm>
#include <cstdint>
#include <glm/gtc/type_ptr.hpp>
#include <vector>

#include "foreview/gpu/draw_tally.h"

namespace foreview::per_polygon {

DepthOwnerPass::DepthOwnerPass(const PolygonModel& model)
    : program_(make_program("per_polygon_depth.vert.glsl", "per_polygon_depth.frag.glsl")),
      vertex_array_(GlVertexArray::create()),
      corner_polygons_(GlBuffer::create()),
      triangles_(GlBuffer::create()) {
  std::vector<std::uint32_t> corner_polygons, triangles;
  for (std::uint32_t i = 0; i < model.polygons().size(); ++i) {
    const auto first = static_cast<std::uint32_t>(corner_polygons.size());
    const std::uint32_t count = model.polygons()[i].corner_count;
    corner_polygons.insert(corner_polygons.end(), count, i);
    for (std::uint32_t k = 2; k < count; ++k) triangles.insert(triangles.end(), {first, first + k - 1, first + k});
  }
  index_count_ = static_cast<GLsizei>(triangles.size());
  const auto bytes = [](const std::vector<std::uint32_t>& data) {
    return static_cast<GLsizeiptr>(data.size() * sizeof(std::uint32_t));
  };
  glNamedBufferData(corner_polygons_.id(), bytes(corner_polygons), corner_polygons.data(), GL_STATIC_DRAW);
  glNamedBufferData(triangles_.id(), bytes(triangles), triangles.data(), GL_STATIC_DRAW);
  const GLuint vao = vertex_array_.id();
  glVertexArrayElementBuffer(vao, triangles_.id());
  glEnableVertexArrayAttrib(vao, 0);
  glVertexArrayAttribFormat(vao, 0, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(vao, 0, 0);
  glEnableVertexArrayAttrib(vao, 1);
  glVertexArrayAttribIFormat(vao, 1, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(vao, 1, 1);
  glVertexArrayVertexBuffer(vao, 1, corner_polygons_.id(), 0, sizeof(std::uint32_t));
}

void DepthOwnerPass::draw(const PictureData& picture, const CameraModel& camera, double near_plane) {
  if (camera.width > room_width_ || camera.height > room_height_) {
    room_width_ = std::max(room_width_, camera.width);
    room_height_ = std::max(room_height_, camera.height);
    owners_ = make_texture_2d(GL_R32UI, room_width_, room_height_);
    depths_ = make_texture_2d(GL_DEPTH_COMPONENT32F, room_width_, room_height_);
    framebuffer_ = make_framebuffer(owners_.id(), depths_.id());
  }
  const glm::mat4 clip_from_camera(camera.clip_from_camera(near_plane));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, camera.width, camera.height);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  const GLuint nobody[4] = {kNobody, 0, 0, 0};
  const GLfloat farthest = 0;
  glClearBufferuiv(GL_COLOR, 0, nobody);
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  glUseProgram(program_.id());
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(clip_from_camera));
  glUniform1f(1, static_cast<float>(near_plane));
  glVertexArrayVertexBuffer(vertex_array_.id(), 0, picture.corners(), 0, 3 * sizeof(float));
  glBindVertexArray(vertex_array_.id());
  count_draw();
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
  glBindVertexArray(0);
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
}

}  // namespace foreview::per_polygon
