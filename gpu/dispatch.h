#pragma once
#include "foreview/gpu/draw_tally.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview {

/// Runs the current compute program once per texel of a width x height image. Its work groups are 8x8; it must itself
/// leave out what lies beyond the image.
inline void dispatch_over(int width, int height) {
  count_draw();
  glDispatchCompute(static_cast<GLuint>(width + 7) / 8, static_cast<GLuint>(height + 7) / 8, 1);
}

/// Between a dispatch that writes an image and one that reads it, as a texture or as an image.
inline void image_barrier() {
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace foreview
