#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "foreview/gpu/texture_store.h"
#include "foreview/scene/camera_frame.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

class SurfaceTarget;

/// Which gaps of a view take the colours around them in the picture (GapFiller).
enum class GapFilling {
  none,
  cracks,  ///< of the model: where what lies behind everything shows through
  all,     ///< also what no picture has shown
};
/// Where registration has found the record to be off, silhouettes and charts' borders are pixels off what pictures
/// show, and what lies around in the picture is the better guess for all gaps (kitchen: rms 17 instead of 22/255);
/// where the model fits, a chart's own fill keeps its outline (workcell: 15 instead of 20).
[[nodiscard]] GapFilling gaps_to_fill(const CameraModel& registered, const CameraModel& recorded);

/// How PredictedView draws.
struct ViewStyle {
  bool holes_pink = false;  ///< filled texels and never-seen polygons in pink (the dissertation's figures)
  bool wireframe = false;   ///< polygon edges over the view, hidden ones left out, without the backdrop's
  bool textures = true;     ///< false: only the wireframe, over what is in the framebuffer
  /// Not where polygons' edges or overlays are drawn, which show what is known, and in full quality only: in software
  /// it takes as long as a fast frame.
  GapFilling gaps = GapFilling::cracks;
  /// Fast: fewer taps, nearest polygons first. Meant for a framebuffer with one sample a pixel.
  ViewQuality quality = ViewQuality::full;
  bool cull_back_faces = false;  ///< so that one can look into a room from outside
  double near_plane = 0.02;      ///< metres

  // Overlays (see Overlays); all go together. They cost a shader of their own, the plain view nothing.
  bool never_seen = false, age = false, density = false;
  Timestamp moment;                      ///< that ages count from
  double age_span = 10;                  ///< seconds at the upper end of the scale of ages
  std::optional<std::uint32_t> polygon;  ///< highlighted, and less so what shares its chart
  /// What this camera saw in this state is lit (Spotlight); both or none. Read during the call only.
  const CaptureState* spotlight = nullptr;
  const CameraModel* spotlight_camera = nullptr;
  [[nodiscard]] bool colours_surfaces() const {
    return holes_pink || never_seen || age || density || polygon || spotlight != nullptr;
  }
  [[nodiscard]] bool fills_gaps() const {
    return gaps != GapFilling::none && quality == ViewQuality::full && textures && !wireframe && !colours_surfaces();
  }
};

/// Draws the textured model as the operator sees it: PredictedState in, picture out. Knows textures only through the
/// store, not how they are made.
///
/// A polygon's front wears its chart (trilinear between levels, up to 4 taps along a footprint's longer axis, no tap
/// ever outside the chart; magnified: bilinear). A polygon that no picture has shown has its state's colour. Nothing is
/// culled: a back face is drawn in its polygon's mean colour, halfway to grey. No picture can ever texture it, but to
/// leave it out would open walls where the model's winding is wrong, or show free space where something solid stands.
class PredictedView {
 public:
  using Style = ViewStyle;
  /// Needs a current context, as do all members. The store must outlive the view.
  explicit PredictedView(const TextureStore& store);
  ~PredictedView();
  PredictedView(const PredictedView&) = delete;
  PredictedView& operator=(const PredictedView&) = delete;

  /// Draws into the viewport (x, y, width, height; pixels) of `framebuffer`. `camera` is scaled to the viewport's
  /// height, aspect kept, centred. Memory row 0 is the picture's top (see CameraModel::clip_from_camera); `flip` turns
  /// it over for a window's framebuffer, whose row 0 is at the bottom.
  struct Viewport {
    int x = 0, y = 0, width = 0, height = 0;
    /// Only these columns are drawn, counted from the viewport's left.
    int first_column = 0, end_column = std::numeric_limits<int>::max();
    [[nodiscard]] int first_x() const { return x + std::min(first_column, width); }
    [[nodiscard]] int end_x() const { return x + std::min(end_column, width); }
    [[nodiscard]] bool is_empty() const { return width < 1 || height < 1 || first_x() >= end_x(); }
  };
  void draw(const CameraModel& camera, const PredictedState& state, const Style& style, GLuint framebuffer,
            const Viewport& viewport, bool flip);

  /// Every lab's first check of its registration: the model's edges as the camera saw it when a picture was taken, over
  /// that picture, which is in the framebuffer already. Clears depth. Otherwise as draw().
  void draw_edges(const CameraModel& camera, const CaptureState& state, GLuint framebuffer, const Viewport& viewport,
                  bool flip, double near_plane = Style().near_plane);

  /// The view as a picture of the camera's size (CV_8UC3 BGR), anti-aliased (4 samples a pixel).
  [[nodiscard]] cv::Mat render(const CameraModel& camera, const PredictedState& state, const Style& style = {});

  /// What lies at each pixel's centre: for measuring. Polygon -1 where nothing is.
  struct Surface {
    cv::Mat polygon;     ///< CV_32S: index of the polygon, or -1
    cv::Mat inverse_z;   ///< CV_32F: 1 / z in metres, 0 where nothing
    cv::Mat provenance;  ///< CV_8U: 2 observed, 1 filled, 0 never seen or nothing (level 0 of the chart decides)
  };
  [[nodiscard]] Surface render_surface(const CameraModel& camera, const PredictedState& state);
  /// The same from a capture state, e.g. to find occluders' contours in a used picture (provenance not meaningful).
  [[nodiscard]] Surface render_surface(const CameraModel& camera, const CaptureState& state);
  /// The same into a target whose size is the camera's, without reading it back. Of the style only near plane and
  /// culling count.
  void draw_surface(const CameraModel& camera, const PredictedState& state, const Style& style,
                    const SurfaceTarget& into);
  [[nodiscard]] const TextureStore& store() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
