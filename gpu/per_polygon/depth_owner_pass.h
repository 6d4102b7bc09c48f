#pragma once
#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/per_polygon/picture_data.h"
#include "foreview/scene/camera_model.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::per_polygon {

/// Rule 1 of PerPolygonExtraction (spec 4): the whole scene from the camera, nearest surface and its polygon.
class DepthOwnerPass {
 public:
  static constexpr GLuint kNobody = 0xFFFFFFFFu;

  explicit DepthOwnerPass(const PolygonModel& model);
  /// Draws `picture`, which must have been prepared with this camera and near plane, in one call.
  void draw(const PictureData& picture, const CameraModel& camera, double near_plane);
  /// GL_R32UI: index of the polygon at each pixel's centre, or kNobody.
  [[nodiscard]] GLuint owners() const { return owners_.id(); }
  /// GL_DEPTH_COMPONENT32F: near_plane / z, 0 where nothing is.
  [[nodiscard]] GLuint depths() const { return depths_.id(); }

 private:
  GlProgram program_;
  GlVertexArray vertex_array_;
  GlBuffer corner_polygons_, triangles_;
  GLsizei index_count_ = 0;
  GlTexture owners_, depths_;
  GlFramebuffer framebuffer_;
  int room_width_ = 0, room_height_ = 0;
};

}  // namespace foreview::per_polygon
