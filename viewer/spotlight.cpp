#include "foreview/viewer/spotlight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

namespace foreview {
namespace {

constexpr int kLongestSide = 512;  // texels: its rim is soft, and in software a pass costs what its pixels cost
constexpr GLuint kPartsBinding = 0;
constexpr glm::vec3 kLineColour{1.0F, 0.85F, 0.35F};

}  // namespace

Spotlight::Spotlight(const ModelBuffers& model)
    : model_(model),
      parts_(model.make_placement()),
      depth_program_(make_program("view_polygons.vert.glsl", "view_wireframe.frag.glsl")),
      frustum_program_(make_program("view_frustum.vert.glsl", "view_wireframe.frag.glsl")),
      no_vertices_(GlVertexArray::create()) {
  glProgramUniform3fv(frustum_program_.id(), glGetUniformLocation(frustum_program_.id(), "line_colour"), 1,
                      glm::value_ptr(kLineColour));
}

void Spotlight::set(const CameraModel& camera, const CaptureState& capture, double near_plane) {
  const bool same = any_ && capture.stamp == capture_.stamp &&
                    capture.world_from_camera == capture_.world_from_camera &&
                    capture.world_from_part == capture_.world_from_part && near_plane == near_plane_ &&
                    camera.width == camera_.width && camera.height == camera_.height &&
                    camera.focal_length == camera_.focal_length && camera.principal_point == camera_.principal_point;
  if (same) return;
  camera_ = camera.undistorted();
  capture_ = capture;
  near_plane_ = near_plane;
  any_ = true;
  draw_depth();
}

void Spotlight::draw_depth() {
  const double scale = std::min(1.0, static_cast<double>(kLongestSide) / std::max(camera_.width, camera_.height));
  const int width = std::max(1, static_cast<int>(std::lround(camera_.width * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(camera_.height * scale)));
  if (width != width_ || height != height_) {
    depth_ = make_texture_2d(GL_DEPTH_COMPONENT32F, width, height);
    framebuffer_ = make_framebuffer(0, depth_.id());
    width_ = width;
    height_ = height;
  }
  model_.place(parts_, camera_, capture_.world_from_camera, capture_.world_from_part, near_plane_, false);
  constexpr GLfloat kFarthest = 0;
  glClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &kFarthest);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, width, height);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPartsBinding, parts_.buffer());
  glUseProgram(depth_program_.id());
  model_.bind();
  model_.draw_triangles();
  glDepthFunc(GL_LESS);
  glDisable(GL_DEPTH_TEST);

  // As far as the middle of the part furthest away, and half as far again: the depth test ends lines where they meet
  // something.
  reach_ = near_plane_;
  const ViewGeometry& geometry = model_.geometry();
  for (std::size_t i = 0; i < geometry.part_centres.size(); ++i) {
    if (geometry.part_is_backdrop[i]) continue;
    const glm::dvec3 centre = capture_.world_from_part[i] * geometry.part_centres[i];
    reach_ = std::max(reach_, 1.5 * glm::distance(centre, capture_.world_from_camera.translation));
  }
}

void Spotlight::draw_frustum(const CameraModel& viewer, const Pose& world_from_viewer, double near_plane,
                             bool flip) const {
  if (!any_) return;
  const std::array<glm::dvec2, 4> pixels{glm::dvec2(0, 0), glm::dvec2(camera_.width, 0),
                                         glm::dvec2(camera_.width, camera_.height), glm::dvec2(0, camera_.height)};
  const Pose viewer_from_camera = world_from_viewer.inverse() * capture_.world_from_camera;
  const glm::dmat4 clip_from_viewer = viewer.clip_from_camera(near_plane);
  std::array<glm::vec4, 9> corners{};
  const auto project = [&](const glm::dvec3& point_in_camera) {
    glm::dvec4 clip = clip_from_viewer * glm::dvec4(viewer_from_camera * point_in_camera, 1);
    if (flip) clip.y = -clip.y;
    return glm::vec4(clip);
  };
  corners[0] = project({0, 0, 0});
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 ray = camera_.ray_from_pixel(pixels[i]);
    corners[1 + i] = project(0.06 * reach_ * ray);
    corners[5 + i] = project(reach_ * ray);
  }
  glUseProgram(frustum_program_.id());
  glUniform4fv(glGetUniformLocation(frustum_program_.id(), "clip_corners"), 9, glm::value_ptr(corners[0]));
  glBindVertexArray(no_vertices_.id());
  glDrawArrays(GL_LINES, 0, 24);
}

}  // namespace foreview
