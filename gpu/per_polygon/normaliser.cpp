#include "foreview/gpu/per_polygon/normaliser.h"

#include "foreview/gpu/dispatch.h"

namespace foreview::per_polygon {

Normaliser::Normaliser()
    : program_(make_compute_program("per_polygon_normalise.comp.glsl")),
      counting_program_(make_compute_program("per_polygon_normalise.comp.glsl", "#define COUNT\n")),
      counter_(GlBuffer::create()) {
  const GLuint none = 0;
  glNamedBufferData(counter_.id(), sizeof none, &none, GL_DYNAMIC_READ);
}

void Normaliser::set_counting(bool on) {
  counting_ = on;
}

void Normaliser::fuse(std::size_t slot, GLuint undistorted, GLuint alpha, double near_plane, bool keep_valid,
                      GLuint fused, int width, int height) {
  glUseProgram(counting_ ? counting_program_.id() : program_.id());
  glUniform1i(0, static_cast<GLint>(slot));
  glUniform1f(1, static_cast<float>(near_plane));
  glUniform1i(2, keep_valid ? 1 : 0);
  if (counting_) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, counter_.id());
  glBindTextureUnit(0, undistorted);
  glBindTextureUnit(1, alpha);
  glBindImageTexture(0, fused, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8);
  dispatch_over(width, height);
  image_barrier();
}

std::size_t Normaliser::take_count() {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  GLuint count = 0;
  const GLuint none = 0;
  glGetNamedBufferSubData(counter_.id(), 0, sizeof count, &count);
  glNamedBufferSubData(counter_.id(), 0, sizeof none, &none);
  return count;
}

}  // namespace foreview::per_polygon
