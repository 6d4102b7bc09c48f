#pragma once
#include <cstddef>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/per_polygon/picture_data.h"

namespace foreview::per_polygon {

/// Rules 5 and 6 of PerPolygonExtraction (spec 6 and 7): from the perspective texture straight into the polygon's
/// texture. Only what is valid now is written, so that normalising and fusing are one step.
class Normaliser {
 public:
  Normaliser();
  /// Into `fused` (GL_RGBA8, `width` x `height`) from the picture and the alpha of the box, for the polygon at `slot`.
  /// `keep_valid`: the picture is older than the texture and only fills what is not valid there. `picture` must be
  /// bound.
  void fuse(std::size_t slot, GLuint undistorted, GLuint alpha, double near_plane, bool keep_valid, GLuint fused,
            int width, int height);
  /// Counts the texels written from now on, or not.
  void set_counting(bool on);
  /// Texels written since the last call. Waits for the GPU.
  [[nodiscard]] std::size_t take_count();

 private:
  GlProgram program_, counting_program_;
  GlBuffer counter_;
  bool counting_ = false;
};

}  // namespace foreview::per_polygon
