#pragma once
#include <opencv2/core/mat.hpp>
#include <utility>

#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/picture_setup.h"
#include "foreview/gpu/extraction.h"
#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/camera_model.h"

namespace foreview::batched {

/// Rules 1 to 4 of BatchedExtraction: from where in the picture which surface may take colours.
class PictureBounds {
 public:
  static constexpr int kCoarse = 8;  ///< cells along the side of a coarse one; the same in batched_patches.glsl

  explicit PictureBounds(const ChartGeometry& geometry);
  /// Textures grow with the largest picture so far and are kept.
  void make_room(int width, int height);
  /// Rule 1. `setup` must be bound.
  void draw_surfaces(const PictureSetup& setup, const CameraModel& camera, double near_plane);
  /// Rules 2 and 3. passes > 0.
  void spread_rims(const CameraModel& camera, int passes);
  /// Rule 4, and its coarse form. `undistorted`: alpha is 0 where a pixel is unusable; 0: all pixels are usable.
  void bound_cells(const CameraModel& camera, bool suppressing, GLuint undistorted);

  /// GL_RG16F: least and greatest 1/z, one texel a cell.
  [[nodiscard]] GLuint cells() const { return cells_.id(); }
  /// GL_RG16F: the least and greatest of kCoarse x kCoarse cells.
  [[nodiscard]] GLuint coarse_cells() const { return coarse_.id(); }
  [[nodiscard]] cv::Mat read_surfaces(int width, int height) const;
  [[nodiscard]] cv::Mat read_unsafe(int width, int height) const;
  [[nodiscard]] cv::Mat read_cells(int width, int height) const;

 private:
  void draw_over(int width, int height, GLuint target, const GlProgram& program);

  const ChartGeometry& geometry_;
  GlProgram scene_, contours_, spread_, spread_twice_, coarsen_;
  GlProgram bound_[4];  ///< by whether something is suppressed, and distorted
  GlBuffer triangles_;
  std::vector<std::uint32_t> indices_;
  GlVertexArray no_vertices_;
  GlTexture surfaces_, depths_, rims_[2], cells_, coarse_;
  GlFramebuffer surfaces_target_, rim_targets_[2], cells_target_, coarse_target_;
  int current_rims_ = 0;
  int room_width_ = 0, room_height_ = 0;
};

}  // namespace foreview::batched
