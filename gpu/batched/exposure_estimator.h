#pragma once
#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/batched/picture_bounds.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::batched {

/// Rule 5 of BatchedExtraction: the gain of a picture against the textures, found and kept on the GPU.
class ExposureEstimator {
 public:
  static constexpr int kLevel = 2;  ///< of the pulled pyramid, that pictures are compared with

  ExposureEstimator(const PolygonModel& model, const ChartLayout& layout, const ChartGeometry& geometry);
  /// Forgets all colours.
  void clear();
  /// Between PatchLists::touch() and the gather; PictureSetup and PatchLists must be bound. First for all candidates of
  /// `patches`, in any number of calls. `undistorted` is the picture, `observed` level kLevel as the pictures so far
  /// left it, `exposure` the Exposure (gpu/exposure.h).
  void count(const CameraModel& camera, double near_plane, GLuint undistorted, const PictureBounds& bounds,
             const PatchLists& patches, GLuint observed, GLuint exposure, const Run& candidates);
  /// Then brings the Exposure up to this picture. `is_late`: one newer than this has been there already.
  void find_gain(GLuint exposure, bool is_late);

 private:
  void bind(GLuint exposure) const;

  GlProgram count_, gain_;
  GlBuffer samples_, counts_, references_;
  GlSampler linear_;
};

}  // namespace foreview::batched
