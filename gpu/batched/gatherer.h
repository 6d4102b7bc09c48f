#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
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
  /// Begins a picture: what is to be drawn. `is_late`: by chart, whether a newer picture has written it. `touched`: the
  /// touched patches, to list their triangles only and in units of kTexelsPerUnit; none: all triangles, one unit.
  void list(const PictureSetup& setup, const std::vector<bool>& is_late, const CameraModel& camera,
            const std::optional<std::span<const std::uint32_t>>& touched);
  static constexpr double kTexelsPerUnit = 16384;  ///< about; a triangle counts as some texels, too
  [[nodiscard]] std::size_t units() const { return unit_ends_.size(); }
  /// At most so many, before it is known which polygons show their front.
  [[nodiscard]] std::size_t most_units(std::span<const std::uint32_t> touched) const;
  /// Draws them in order, in any number of calls. `undistorted` is the picture, `exposure` its Exposure
  /// (gpu/exposure.h). PictureSetup and PatchLists must be bound.
  void gather(const CameraModel& camera, double near_plane, GLuint undistorted, GLuint exposure,
              const PictureBounds& bounds, const PatchLists& patches, const LayerTargets& into, const Run& units);
  /// Texels of the picture's polygons, by area: before patches that can change nothing are left out.
  [[nodiscard]] std::size_t texels() const { return static_cast<std::size_t>(std::llround(texels_)); }
  void set_counting(bool on) { counting_ = on; }
  /// Texels of the picture that took a colour, if counting was on. Waits for the GPU.
  [[nodiscard]] std::size_t observed() const;

 private:
  const ChartGeometry& geometry_;
  const ChartLayout& layout_;
  GlProgram one_sample_, footprint_;
  GlBuffer index_buffer_;
  GlSampler linear_;
  std::vector<std::uint32_t> indices_;
  double texels_ = 0;
  struct Draw {
    bool late = false, close = false;
    std::size_t end = 0;  ///< index
  };
  std::array<Draw, 6> draws_;
  std::vector<std::size_t> unit_ends_;  ///< indices
  std::vector<bool> is_touched_;        ///< by patch
  std::vector<float> patch_texels_;     ///< likewise: of all triangles in it, as units count them
  std::vector<GlSamplesQuery> taken_;   ///< one for each call of gather()
  std::size_t queries_used_ = 0;
  bool counting_ = false;
};

}  // namespace foreview::batched
