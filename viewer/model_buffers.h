#pragma once
#include <span>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"
#include "foreview/viewer/draw_order.h"
#include "foreview/viewer/view_geometry.h"

namespace foreview {

/// A model on the GPU, ready to be drawn from anywhere: what the predicted view and the spotlight share. Needs a
/// current context in every member; its vertex array belongs to the one that it was made in.
class ModelBuffers {
 public:
  ModelBuffers(const PolygonModel& model, const ChartLayout& layout);
  ~ModelBuffers() = default;
  ModelBuffers(const ModelBuffers&) = delete;
  ModelBuffers& operator=(const ModelBuffers&) = delete;

  /// One matrix a part, for a shader that transforms ViewGeometry::Vertex::position.
  class Placement {
   public:
    explicit Placement(std::size_t parts);
    [[nodiscard]] GLuint buffer() const { return buffer_.id(); }

   private:
    friend class ModelBuffers;
    GlBuffer buffer_;
    std::vector<glm::mat4> matrices_;
  };
  [[nodiscard]] Placement make_placement() const { return Placement(geometry_.part_centres.size()); }
  /// To clip coordinates of this camera: matrices are multiplied in double, so that a model far from the origin does
  /// not tremble. `flip` turns the picture over.
  void place(Placement& placement, const CameraModel& camera, const Pose& world_from_camera,
             std::span<const Pose> world_from_part, double near_plane, bool flip) const;

  [[nodiscard]] const ViewGeometry& geometry() const { return geometry_; }
  [[nodiscard]] GLuint charts() const { return charts_.id(); }
  /// Binds what the draws below read.
  void bind() const;
  /// All triangles, in the order of the polygons or front to back as sort() last left them.
  void draw_triangles(bool sorted = false) const;
  void sort(const Pose& world_from_camera, std::span<const Pose> world_from_part);
  void draw_edges() const;

 private:
  ViewGeometry geometry_;
  DrawOrder order_;
  GlBuffer vertices_, triangles_, sorted_triangles_, edges_, charts_;
  GlVertexArray vao_;
};

}  // namespace foreview
