#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/batched/picture_bounds.h"
#include "foreview/gpu/batched/picture_setup.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::batched {

/// Keeps TextureStore::capture_times(): of each block of 16 x 16 texels one, the one nearest to its middle with its
/// centre in a polygon, is asked whether the picture gives it a colour (rule 5). A block without such a texel takes the
/// answer of the nearest one of its chart that has one.
class CaptureMarker {
 public:
  CaptureMarker(const PolygonModel& model, const ChartLayout& layout, const ChartGeometry& geometry);
  /// Marks, of the touched patches, what the picture gives a colour with `time`. After PatchLists::touch(); `setup` and
  /// `patches` must be bound. `is_late` as Gatherer::gather(). All of them, or a run as PatchLists::dispatch_touched().
  void mark(GLuint capture_times, std::int32_t time, const PictureSetup& setup, const std::vector<bool>& is_late,
            const CameraModel& camera, double near_plane, const PictureBounds& bounds, const PatchLists& patches,
            const std::optional<Run>& groups = {});

 private:
  GlProgram program_;
  GlBuffer samples_, late_charts_;
  std::vector<GLuint> late_bits_;
};

}  // namespace foreview::batched
