#pragma once
#include <cstdint>
#include <vector>

#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/page_targets.h"
#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/batched/picture_bounds.h"
#include "foreview/gpu/batched/picture_setup.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::batched {

/// Rule 5 of BatchedExtraction: draws the visible charts in texture space.
class Gatherer {
 public:
  Gatherer(const ChartGeometry& geometry, const ChartLayout& layout);
  /// `is_late`: by chart, whether a newer picture has written it. `undistorted` is the picture,
  /// `exposure` its Exposure (gpu/exposure.h).
  /// PictureSetup and PatchLists must be bound.
  void gather(const PictureSetup& setup, const std::vector<bool>& is_late, const CameraModel& camera, double near_plane,
              GLuint undistorted, GLuint exposure, const PictureBounds& bounds, const PatchLists& patches,
              const LayerTargets& into);
  /// Texels of what was drawn last, by area: before patches that can change nothing are left out.
  [[nodiscard]] std::size_t texels() const { return static_cast<std::size_t>(texels_ + 0.5); }
  void set_counting(bool on) { counting_ = on; }
  /// Texels that took a colour when it was drawn last, if counting was on. Waits for the GPU.
  [[nodiscard]] std::size_t observed() const;

 private:
  const ChartGeometry& geometry_;
  const ChartLayout& layout_;
  GlProgram one_sample_, footprint_;
  GlBuffer index_buffer_;
  GlSampler linear_;
  std::vector<std::uint32_t> indices_;
  double texels_ = 0;
  GlSamplesQuery taken_;
  bool counting_ = false, counted_ = false;
};

}  // namespace foreview::batched
