#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/gpu/gl_objects.h"
#include "foreview/viewer/frame_input.h"
#include "foreview/viewer/frame_painter.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/render_target.h"
#include "foreview/viewer/undistortion.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// Puts together what the operator sees of a display instant: the predicted view, the delayed picture (without lens
/// distortion, on black before the first one has come), both, or their comparison; with overlays, and with a warning
/// where what is shown is stale: then colours leave the predicted view by and by, a border surrounds the frame, and a
/// text says what is how old. Window and headless replay both show what this draws. Needs a current context in every
/// member; waits for nothing.
class FrameComposer {
 public:
  /// `camera`: the operator's, as it takes pictures (with its distortion). `near_plane` in metres. The view must
  /// outlive the composer.
  FrameComposer(PredictedView& view, const CameraModel& camera, double near_plane);

  struct Size {
    int width = 0, height = 0;
    bool operator==(const Size&) const = default;
  };
  /// Size of the frame in which the camera's pictures have their own size.
  [[nodiscard]] Size native_size(ViewMode mode) const;
  /// The largest frame of the same aspect within these bounds (pixels, at least 1 x 1).
  [[nodiscard]] Size fitting_size(ViewMode mode, int width, int height) const;

  /// Where in a frame of this size the predicted view is.
  [[nodiscard]] static PredictedView::Viewport predicted_viewport(const ViewChoice& choice, const Size& size);

  /// Draws the frame with the textures as they are.
  void compose(const FrameInput& input, const ViewChoice& choice, const Size& size);
  /// The last frame composed: a framebuffer of that size, row 0 its top.
  [[nodiscard]] GLuint framebuffer() { return target_.resolve(); }
  /// The same read back, CV_8UC3 BGR.
  [[nodiscard]] cv::Mat read() { return target_.read(); }

 private:
  using Viewport = PredictedView::Viewport;
  /// A picture on the GPU, without distortion, with levels.
  struct Shown {
    GlTexture texture;
    std::uint64_t key = 0;
    bool any = false;
  };
  void draw_predicted(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport);
  void finish_predicted(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport);
  void annotate(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport);
  void draw_over(const GlProgram& program, const Viewport& viewport);
  void draw_delayed(const FrameInput& input, const ViewChoice& choice, const Viewport& viewport);
  bool load(const FramePicture& picture, Shown& into);

  PredictedView& view_;
  CameraModel camera_;  ///< without distortion
  Undistortion undistortion_;
  double near_plane_;
  AntialiasedTarget target_;
  FramePainter painter_;
  GlTexture unfinished_;  ///< copy of the frame, where something is to be done to it
  Size unfinished_size_;
  GlProgram picture_program_, finish_program_;
  GlVertexArray no_vertices_;
  GlSampler picture_sampler_;
  Shown delayed_, truth_;
};

}  // namespace foreview
