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
  // All that follow come in this order, each for all rows in any number of calls. `setup` must be bound.

  /// Pixels or cells from row `first` on.
  struct Rows {
    int first = 0, count = 0;
  };
  /// Before rule 1.
  void clear_surfaces();
  /// Rule 1.
  void draw_surfaces(const PictureSetup& setup, const CameraModel& camera, double near_plane, const Rows& rows);
  /// Rules 2 and 3 take so many passes over the picture: the contours, then the diamond passes, mostly two at a time.
  [[nodiscard]] static int rim_passes(int diamond_passes) { return 1 + (diamond_passes + 1) / 2; }
  /// diamond_passes > 0.
  void draw_rims(const CameraModel& camera, int diamond_passes, int rim_pass, const Rows& rows);
  /// Rule 4. `diamond_passes`: 0 for no suppression. `undistorted`: alpha is 0 where a pixel is unusable; 0: all pixels
  /// are usable. Rows of cells, one less than pixels.
  void bound_cells(const CameraModel& camera, int diamond_passes, GLuint undistorted, const Rows& rows);
  /// Rows of coarse cells.
  void coarsen(const CameraModel& camera, const Rows& rows);
  [[nodiscard]] static int coarse_rows(const CameraModel& camera) {
    return (camera.height - 1 + kCoarse - 1) / kCoarse;
  }

  /// GL_RG16F: least and greatest 1/z, one texel a cell; the greatest negative where they hold for thin polygons only.
  [[nodiscard]] GLuint cells() const { return cells_.id(); }
  /// GL_RG16F: the least and greatest of kCoarse x kCoarse cells.
  [[nodiscard]] GLuint coarse_cells() const { return coarse_.id(); }
  [[nodiscard]] cv::Mat read_surfaces(int width, int height) const;
  [[nodiscard]] cv::Mat read_unsafe(int width, int height) const;
  [[nodiscard]] cv::Mat read_cells(int width, int height) const;

 private:
  void draw_over(int width, int height, const Rows& rows, GLuint target, const GlProgram& program);

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
