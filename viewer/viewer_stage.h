#pragma once
#include <optional>

#include "foreview/viewer/display_loop.h"
#include "foreview/viewer/feed.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/interface.h"
#include "foreview/viewer/live_frames.h"
#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/panel_layout.h"
#include "foreview/viewer/polygon_probe.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/viewer_control.h"
#include "foreview/viewer/viewer_status.h"
#include "foreview/viewer/window.h"

namespace foreview {

/// Everything of the viewer that lives in graphics contexts: textures, views, panels. Made anew after a context was
/// lost; what the user has set outlives it.
class ViewerStage {
 public:
  /// All must outlive the stage; the window's context is current.
  ViewerStage(Window& window, Feed& feed, ViewerControl& control);

  [[nodiscard]] LiveScene& scene() { return scene_; }
  [[nodiscard]] Interface& interface() { return interface_; }
  /// The operator's, as the last frame was drawn for.
  [[nodiscard]] const CameraModel& camera_model() const { return camera_model_; }
  /// Size of the window for a picture in its own size, or enlarged if that is small, with the panels beside it.
  [[nodiscard]] FrameComposer::Size wanted_window() const;

  /// One frame: takes in the mouse, draws panels and view. `t`: display time when the frame will be seen; `since`: see
  /// LiveFrames::at().
  void draw(const FrameMoment& moment, Timestamp t, Timestamp since, const ViewerStatus& status);
  /// What is under the cursor, into the status; nothing where that is not asked for.
  void tell_probe(ViewerStatus& status) const;
  [[nodiscard]] bool truth_known() const { return frames_.truth_known(); }

  /// The last frame again, in the camera's own size, read back: CV_8UC3 BGR; empty before the first frame.
  [[nodiscard]] cv::Mat take_picture();
  /// How well the view is drawn from now on, if not better than was asked for; take_picture() does not follow it.
  void set_display_quality(ViewQuality quality) { display_quality_ = quality; }
  /// Other extraction options from the next picture on. Nothing may be being extracted.
  void set_extraction(const ExtractionOptions& options);

 private:
  void make_composer();
  void take_in_mouse();
  void advance_camera(const FrameMoment& moment, Timestamp t);

  Window& window_;
  Feed& feed_;
  ViewerControl& control_;
  Interface interface_;
  LiveScene scene_;
  PredictedView view_;
  std::optional<FrameComposer> composer_;
  std::optional<PolygonProbe> probe_;
  std::optional<glm::dvec2> cursor_;  ///< pixels of the frame
  LiveFrames frames_;
  CameraModel camera_model_;  ///< as it takes pictures
  PanelLayout layout_;
  Window::Area view_area_;  ///< pixels
  FrameComposer::Size frame_size_;
  FrameInput* shown_ = nullptr;
  ViewQuality display_quality_ = ViewQuality::full;
  std::optional<Timestamp> advanced_to_;  ///< steady clock
};

}  // namespace foreview
