#pragma once
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <utility>
#include <vector>

#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/camera_frame.h"

namespace foreview::batched {

/// What the CPU finds out about one picture: which polygons can take texels from it, and everybody's plane.
class PictureSetup {
 public:
  PictureSetup(const PolygonModel& model, const ChartLayout& layout, const ChartGeometry& geometry);

  void prepare(const CameraModel& camera, const CaptureState& state, double near_plane);
  /// The same in pieces: begin(), then cull() for all polygons in order, then finish().
  void begin(const CameraModel& camera, const CaptureState& state, double near_plane);
  void cull(std::size_t first, std::size_t count);
  void finish();
  [[nodiscard]] std::size_t polygons() const { return model_.polygons().size(); }
  /// Binds the buffers of batched_common.glsl.
  void bind() const;
  struct Visible {
    std::uint32_t polygon = 0;
    bool is_close = false;  ///< its texels can be larger than BatchedExtraction::kFootprint pixels
  };
  /// Front faces with a part in the picture (as far as a ball around them tells), ascending.
  [[nodiscard]] const std::vector<Visible>& visible() const { return visible_; }
  /// All polygons with a part in the picture, back faces too, roughly the nearest first: what is drawn first hides the
  /// rest before it is shaded.
  [[nodiscard]] const std::vector<std::uint32_t>& front_to_back() const { return front_to_back_; }
  /// By polygon, of those in front_to_back(): the rows of the picture that it may reach into, as first and last pixel;
  /// perhaps beyond the picture.
  struct Rows {
    float first = 0, last = 0;
  };
  [[nodiscard]] const std::vector<Rows>& rows() const { return rows_; }
  /// Charts (ChartLayout::groups) with at least one of them, in no order.
  [[nodiscard]] const std::vector<std::uint32_t>& charts() const { return charts_; }
  /// By chart, of those in charts(): the greatest s (rule 5) of its visible polygons, 1/m. Others: anything.
  [[nodiscard]] const std::vector<float>& slacks() const { return slacks_; }
  [[nodiscard]] std::size_t back_faces() const { return back_faces_; }
  [[nodiscard]] std::size_t outside() const { return outside_; }

 private:
  struct PlaneOnGpu {
    float inverse_z[4], range[4];
  };
  struct Bound {
    glm::dvec3 centre{0};
    double radius = 0;
  };
  struct PartView {
    glm::dmat3 rotation{1};
    glm::dvec3 translation{0};
    glm::dvec4 sides[4];  // part frame, inwards, unit normals
    glm::dvec4 front{0};  // z - near
  };
  const PolygonModel& model_;
  const ChartLayout& layout_;
  const ChartGeometry& geometry_;
  std::vector<Bound> bounds_;  ///< by polygon, part frame
  CameraModel camera_;
  double near_plane_ = 0;
  std::vector<PartView> views_;
  std::vector<glm::dvec2> corners_;  ///< of the polygon at hand, projected
  std::vector<Rows> rows_;
  std::vector<Visible> visible_;
  std::vector<std::pair<float, std::uint32_t>> by_distance_;  ///< least z, polygon
  std::vector<std::uint32_t> front_to_back_;
  std::vector<std::uint32_t> charts_;
  std::vector<float> slacks_;
  std::vector<bool> chart_listed_;
  std::size_t back_faces_ = 0, outside_ = 0;
  std::vector<glm::mat4> parts_;
  std::vector<PlaneOnGpu> planes_;
  GlBuffer part_buffer_, plane_buffer_;
};

}  // namespace foreview::batched
