#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>

#include "foreview/gpu/gl_objects.h"
#include "foreview/viewer/render_target.h"
#include "foreview/viewer/replay_control.h"
#include "foreview/viewer/replayer.h"

namespace foreview {

/// Puts together what the operator sees of a display instant: the predicted view, the delayed picture (without lens
/// distortion, on black before the first one has come), or the predicted view at the left of the delayed picture; with
/// overlays. Window and headless replay both show what this draws. Needs a current context in every member.
class FrameComposer {
 public:
  /// `near_plane` in metres. The replayer must outlive the composer.
  FrameComposer(Replayer& replayer, double near_plane);

  struct Size {
    int width = 0, height = 0;
  };
  /// Size of the frame in which the camera's pictures have their own size.
  [[nodiscard]] Size native_size(DisplayMode mode) const;
  /// The largest frame of the same aspect within these bounds (pixels, at least 1 x 1).
  [[nodiscard]] Size fitting_size(DisplayMode mode, int width, int height) const;

  /// Draws the frame of display time t with the textures as they are: call Replayer::advance_to(t) before.
  void compose(Timestamp t, const DisplayChoice& choice, const Size& size);
  /// The last frame composed: a framebuffer of that size, row 0 its top.
  [[nodiscard]] GLuint framebuffer() { return target_.resolve(); }
  /// The same read back, CV_8UC3 BGR.
  [[nodiscard]] cv::Mat read() { return target_.read(); }

 private:
  void draw_predicted(Timestamp t, const DisplayChoice& choice, const PredictedView::Viewport& viewport);
  void draw_delayed(const DisplayChoice& choice, const PredictedView::Viewport& viewport);
  void load_delayed_picture();

  Replayer& replayer_;
  double near_plane_;
  AntialiasedTarget target_;
  GlProgram picture_program_;
  GlVertexArray no_vertices_;
  GlTexture picture_;
  GlSampler picture_sampler_;
  std::optional<std::size_t> picture_index_;  ///< what `picture_` holds
};

}  // namespace foreview
