#pragma once
#include <cstdint>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/per_polygon/polygon_textures.h"
#include "foreview/gpu/per_polygon/projection.h"
#include "foreview/scene/camera_frame.h"
#include "foreview/scene/chart_layout.h"

namespace foreview::per_polygon {

/// All that the shaders must know about the polygons of one picture (gpu/shaders/per_polygon_common.glsl): computed on
/// the CPU in double precision, relative to the camera and to each polygon's box, and uploaded once a picture.
class PictureData {
 public:
  /// All arguments must outlive this. Needs a current context.
  PictureData(const PolygonModel& model, const ChartLayout& layout, const PolygonTextures& textures);

  /// A polygon that is in the picture, at the index that the shaders call its slot.
  struct Visible {
    std::uint32_t polygon = 0;
    PixelBox box;
    int shorter_side = 0;     ///< of the box before growing
    bool has_outline = true;  ///< false: only its box is in the picture, and no pixel can be its own
  };

  /// Projects all polygons and uploads.
  void prepare(const CameraModel& camera, const CaptureState& state, double near_plane);
  [[nodiscard]] const std::vector<Visible>& visible() const { return visible_; }
  [[nodiscard]] std::size_t count(Fate fate) const { return fates_[static_cast<std::size_t>(fate)]; }
  /// Binds the buffers of per_polygon_common.glsl and those of the mask (bindings 0..3).
  void bind() const;
  /// Corners of all polygons one after the other, in the camera's frame: three floats each.
  [[nodiscard]] GLuint corners() const { return corner_buffer_.id(); }

 private:
  struct PlaneOnGpu {
    float inverse_z[4], reference[4];
  };
  struct EdgeOnGpu {
    float line[4], extent[4];
  };
  struct PolygonOnGpu {
    std::int32_t box[4], texture_size[4];
    std::uint32_t lists[4];
    float u_row[4], v_row[4], z_row[4], reference[4];
    std::int32_t chart_block[4];
    float texel_columns[4], texel_offset[4];
  };
  void add_visible(std::uint32_t polygon, const ProjectedPolygon& projected, const CameraModel& camera,
                   const Pose& camera_from_part);

  const PolygonModel& model_;
  const ChartLayout& layout_;
  const PolygonTextures& textures_;
  std::vector<std::uint32_t> first_neighbour_;
  std::vector<Visible> visible_;
  std::size_t fates_[4] = {};
  std::vector<float> corners_;
  std::vector<PlaneOnGpu> planes_;
  std::vector<EdgeOnGpu> edges_;
  std::vector<PolygonOnGpu> polygons_;
  GlBuffer corner_buffer_, plane_buffer_, edge_buffer_, polygon_buffer_, neighbour_buffer_;
};

}  // namespace foreview::per_polygon
