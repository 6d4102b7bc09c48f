#pragma once
#include <cstddef>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/per_polygon/depth_owner_pass.h"
#include "foreview/gpu/per_polygon/picture_data.h"

namespace foreview::per_polygon {

/// Rule 3 of PerPolygonExtraction (spec 4 and 8): alpha of the pixels of a polygon's box.
class OcclusionMask {
 public:
  OcclusionMask();
  /// Into the first box.width x box.height texels of `alpha` (GL_R32F), for the polygon at `slot`. `undistorted` is
  /// the picture with its usable pixels in alpha. `picture` must be bound.
  void judge(const PictureData& picture, std::size_t slot, GLuint undistorted, const DepthOwnerPass& scene,
             double near_plane, GLuint alpha);

 private:
  GlProgram program_;
};

}  // namespace foreview::per_polygon
