#include "foreview/gpu/batched/picture_bounds.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <string>

#include "foreview/gpu/batched/batched_extraction.h"
#include "foreview/gpu/draw_tally.h"

namespace foreview::batched {
namespace {

cv::Mat read(GLuint texture, int width, int height, int type, GLenum format) {
  cv::Mat result(height, width, type);
  glGetTextureSubImage(texture, 0, 0, 0, 0, width, height, 1, format, GL_FLOAT,
                       static_cast<GLsizei>(result.total() * result.elemSize()), result.data);
  return result;
}

}  // namespace

PictureBounds::PictureBounds(const ChartGeometry& geometry)
    : geometry_(geometry),
      scene_(make_program("batched_scene.vert.glsl", "batched_scene.frag.glsl")),
      contours_(make_program("fullscreen.vert.glsl", "batched_contours.frag.glsl")),
      spread_(make_program("fullscreen.vert.glsl", "batched_spread.frag.glsl")),
      spread_twice_(make_program("fullscreen.vert.glsl", "batched_spread.frag.glsl", "#define TWICE\n")),
      coarsen_(make_program("fullscreen.vert.glsl", "batched_coarse.frag.glsl")),
      triangles_(GlBuffer::create()),
      no_vertices_(GlVertexArray::create()) {
  for (int i = 0; i < 4; ++i) {
    const std::string defines = std::string(i & 1 ? "#define SUPPRESS\n" : "") + (i & 2 ? "#define DISTORTED\n" : "");
    bound_[i] = make_program("fullscreen.vert.glsl", "batched_cells.frag.glsl", defines.c_str());
  }
  glNamedBufferStorage(triangles_.id(),
                       static_cast<GLsizeiptr>(std::max<std::size_t>(geometry.scene_index_count(), 1) * sizeof(GLuint)),
                       nullptr, GL_DYNAMIC_STORAGE_BIT);
}

void PictureBounds::make_room(int width, int height) {
  if (width <= room_width_ && height <= room_height_) return;
  room_width_ = std::max(width, room_width_);
  room_height_ = std::max(height, room_height_);
  surfaces_ = make_texture_2d(GL_RGBA32F, room_width_, room_height_);
  depths_ = make_texture_2d(GL_DEPTH_COMPONENT32F, room_width_, room_height_);
  surfaces_target_ = make_framebuffer(surfaces_.id(), depths_.id());
  for (int i = 0; i < 2; ++i) {
    rims_[i] = make_texture_2d(GL_R16F, room_width_, room_height_);
    rim_targets_[i] = make_framebuffer(rims_[i].id());
  }
  cells_ = make_texture_2d(GL_RG16F, room_width_, room_height_);
  cells_target_ = make_framebuffer(cells_.id());
  coarse_ = make_texture_2d(GL_RG16F, room_width_ / kCoarse + 1, room_height_ / kCoarse + 1);
  coarse_target_ = make_framebuffer(coarse_.id());
}

void PictureBounds::clear_surfaces() {
  const GLfloat nothing[4] = {0, 0, 0, 0};
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, surfaces_target_.id());
  glDepthMask(GL_TRUE);
  glClearBufferfv(GL_COLOR, 0, nothing);
  glClearBufferfv(GL_DEPTH, 0, nothing);
}

void PictureBounds::draw_surfaces(const PictureSetup& setup, const CameraModel& camera, double near_plane,
                                  const Rows& rows) {
  indices_.clear();
  const bool is_all = rows.count >= camera.height;
  const auto first_row = static_cast<float>(rows.first), end_row = static_cast<float>(rows.first + rows.count);
  for (const std::uint32_t polygon : setup.front_to_back()) {
    const PictureSetup::Rows& own = setup.rows()[polygon];
    if (!is_all && (own.last < first_row || own.first > end_row)) continue;
    const auto [first, count] = geometry_.corners(polygon);
    for (std::uint32_t k = 2; k < count; ++k) indices_.insert(indices_.end(), {first, first + k - 1, first + k});
  }
  glNamedBufferSubData(triangles_.id(), 0, static_cast<GLsizeiptr>(indices_.size() * sizeof(GLuint)), indices_.data());
  const glm::mat4 clip_from_camera(camera.clip_from_camera(near_plane));
  const glm::vec2 centre(camera.principal_point);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, surfaces_target_.id());
  glViewport(0, 0, camera.width, camera.height);
  if (!is_all) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, rows.first, camera.width, rows.count);
  }
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glUseProgram(scene_.id());
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(clip_from_camera));
  glUniform2fv(1, 1, glm::value_ptr(centre));
  glVertexArrayElementBuffer(geometry_.vertex_array(), triangles_.id());
  glBindVertexArray(geometry_.vertex_array());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(indices_.size()), GL_UNSIGNED_INT, nullptr);
  count_draw();
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
}

void PictureBounds::draw_over(int width, int height, const Rows& rows, GLuint target, const GlProgram& program) {
  glBindVertexArray(no_vertices_.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
  glViewport(0, 0, width, height);
  if (rows.count < height) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, rows.first, width, rows.count);
  }
  glUseProgram(program.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  count_draw();
  glDisable(GL_SCISSOR_TEST);
}

void PictureBounds::draw_rims(const CameraModel& camera, int diamond_passes, int rim_pass, const Rows& rows) {
  current_rims_ = rim_pass % 2;
  const GLuint target = rim_targets_[current_rims_].id();
  if (rim_pass == 0) {
    glProgramUniform2i(contours_.id(), 0, camera.width - 1, camera.height - 1);
    glProgramUniform1f(contours_.id(), 1, BatchedExtraction::kGap);
    glBindTextureUnit(0, surfaces_.id());
    draw_over(camera.width, camera.height, rows, target, contours_);
    return;
  }
  // One diamond pass if their number is odd, then two at a time.
  const GlProgram& program = rim_pass == 1 && diamond_passes % 2 == 1 ? spread_ : spread_twice_;
  glProgramUniform2i(program.id(), 0, camera.width - 1, camera.height - 1);
  glBindTextureUnit(0, rims_[1 - current_rims_].id());
  draw_over(camera.width, camera.height, rows, target, program);
}

void PictureBounds::bound_cells(const CameraModel& camera, int diamond_passes, GLuint undistorted, const Rows& rows) {
  const GlProgram& program = bound_[(diamond_passes > 0 ? 1 : 0) + (undistorted != 0 ? 2 : 0)];
  if (diamond_passes > 0) current_rims_ = (rim_passes(diamond_passes) - 1) % 2;
  glProgramUniform1f(program.id(), 0, BatchedExtraction::kGap);
  glProgramUniform1f(program.id(), 1, BatchedExtraction::kRounding);
  glBindTextureUnit(0, surfaces_.id());
  glBindTextureUnit(1, rims_[current_rims_].id());
  if (undistorted != 0) glBindTextureUnit(2, undistorted);
  draw_over(camera.width - 1, camera.height - 1, rows, cells_target_.id(), program);
}

void PictureBounds::coarsen(const CameraModel& camera, const Rows& rows) {
  const int columns = camera.width - 1;
  glProgramUniform2i(coarsen_.id(), 0, columns - 1, camera.height - 2);
  glBindTextureUnit(0, cells_.id());
  draw_over((columns + kCoarse - 1) / kCoarse, coarse_rows(camera), rows, coarse_target_.id(), coarsen_);
}

cv::Mat PictureBounds::read_surfaces(int width, int height) const {
  return read(surfaces_.id(), width, height, CV_32FC3, GL_RGB);
}

cv::Mat PictureBounds::read_unsafe(int width, int height) const {
  return read(rims_[current_rims_].id(), width, height, CV_32F, GL_RED);
}

cv::Mat PictureBounds::read_cells(int width, int height) const {
  return read(cells_.id(), width - 1, height - 1, CV_32FC2, GL_RG);
}

}  // namespace foreview::batched
