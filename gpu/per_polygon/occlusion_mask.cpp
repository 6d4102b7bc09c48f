#include "foreview/gpu/per_polygon/occlusion_mask.h"

#include "foreview/gpu/dispatch.h"

namespace foreview::per_polygon {

OcclusionMask::OcclusionMask() : program_(make_compute_program("per_polygon_mask.comp.glsl")) {}

void OcclusionMask::judge(const PictureData& picture, std::size_t slot, GLuint undistorted, const DepthOwnerPass& scene,
                          double near_plane, GLuint alpha) {
  const PixelBox& box = picture.visible()[slot].box;
  glUseProgram(program_.id());
  glUniform1i(0, static_cast<GLint>(slot));
  glUniform1f(1, static_cast<float>(near_plane));
  const GLuint textures[] = {undistorted, scene.owners(), scene.depths()};
  glBindTextures(0, 3, textures);
  glBindImageTexture(0, alpha, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch_over(box.width, box.height);
  image_barrier();
}

}  // namespace foreview::per_polygon
