#pragma once
#include <cstdint>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/camera_frame.h"
#include "foreview/scene/camera_model.h"
#include "foreview/viewer/model_buffers.h"

namespace foreview {

/// A camera's field of view as a spotlight cone lying on the scene (spec 13): what it saw of each surface, where that
/// surface was when the picture was taken (M_t), wherever it is drawn now. So it lies on what the picture gave colours
/// to, and on nothing that was hidden from it. Needs a current context in every member.
class Spotlight {
 public:
  explicit Spotlight(const ModelBuffers& model);

  /// The camera and state of a picture; draws its depth anew where they differ from the last ones. Leaves another
  /// framebuffer, program and vertex array bound than before. An empty picture size lights nothing.
  void set(const CameraModel& camera, const CaptureState& capture, double near_plane);
  /// Its depth as clip coordinates have it (reversed), the picture's top in row 0.
  [[nodiscard]] GLuint depth() const { return depth_.id(); }
  [[nodiscard]] GLuint parts() const { return parts_.buffer(); }

  /// The frustum's lines, in the colour of light, hidden where the framebuffer's depth hides them, over as far as the
  /// model reaches. Draws into what is bound.
  void draw_frustum(const CameraModel& viewer, const Pose& world_from_viewer, double near_plane, bool flip) const;

 private:
  void draw_depth();

  const ModelBuffers& model_;
  ModelBuffers::Placement parts_;
  GlProgram depth_program_, frustum_program_;
  GlVertexArray no_vertices_;
  GlTexture depth_;
  GlFramebuffer framebuffer_;
  int width_ = 0, height_ = 0;
  CameraModel camera_;
  CaptureState capture_;
  double near_plane_ = 0, reach_ = 1;
  bool any_ = false;
};

}  // namespace foreview
