#pragma once
#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "foreview/gpu/gl_objects.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/frame_input.h"
#include "foreview/viewer/polygon_report.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/surface_target.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// What lies under the cursor in the predicted view, and what is known of it. Draws the one pixel again and reads it,
/// and then the polygon's texels, through pixel buffers: never waits; answers come a frame or two later. Needs a
/// current context in every member.
class PolygonProbe {
 public:
  /// Of the composer's frames. The view must outlive the probe.
  PolygonProbe(PredictedView& view, const CameraModel& camera, double near_plane);

  /// Once a frame: takes in what has been read, and asks for what is under `cursor` (pixels of the frame, of `size`,
  /// composed from these; y down), where nothing else is being asked. No cursor, or one that is not over the predicted
  /// view: nothing is under it, from now on.
  void update(const FrameInput& input, const ViewChoice& choice, const FrameComposer::Size& size,
              std::optional<glm::dvec2> cursor);

  /// What was last found under a pixel.
  struct Found {
    std::uint32_t polygon = 0;
    glm::dvec3 point_in_world{0};
    double distance = 0;  ///< metres along the line of sight's axis
    enum class Provenance { never_seen, filled, observed } provenance = Provenance::never_seen;
    std::optional<Timestamp> captured;  ///< of the texel's colour, in milliseconds; none: never, or not known
  };
  [[nodiscard]] const std::optional<Found>& found() const { return found_; }
  /// Of the polygon found; its texels are filled in a frame or two later, and again with every new picture.
  [[nodiscard]] const std::optional<PolygonReport>& report() const { return report_; }

 private:
  void ask_pixel(const FrameInput& input, const ViewChoice& choice, const PredictedView::Viewport& viewport,
                 const glm::ivec2& pixel);
  void take_pixel();
  void ask_texels();
  void take_texels();

  PredictedView& view_;
  CameraModel camera_;
  double near_plane_;

  SurfaceTarget target_;
  GlBuffer pixel_buffer_;
  struct PixelQuestion {
    GlFence fence;
    glm::dvec3 ray{0};  ///< in the camera, z 1
    Pose world_from_camera;
    Timestamp epoch;
  };
  std::optional<PixelQuestion> pixel_question_;

  GlBuffer texel_buffer_;
  std::size_t texel_bytes_ = 0;
  struct TexelQuestion {
    GlFence fence;
    std::uint32_t polygon = 0;
    TexelBox box;
    glm::ivec2 blocks{0, 0};
    std::size_t times_offset = 0;
    Timestamp epoch;
    std::uint64_t picture = 0;
  };
  std::optional<TexelQuestion> texel_question_;
  std::optional<std::uint64_t> counted_picture_;  ///< Shown::picture that report_ was last counted at

  bool over_view_ = false;
  std::optional<Found> found_;
  std::optional<PolygonReport> report_;
};

}  // namespace foreview
