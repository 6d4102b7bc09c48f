#pragma once
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::oracle {

/// A polygon model of the faces given by their corners, each corner a vertex of its own unless two are equal. Nothing
/// is merged, and there is no backdrop. `face_part` as in RawMesh.
[[nodiscard]] inline PolygonModel model_of(const std::vector<std::vector<glm::dvec3>>& faces,
                                           const std::vector<std::uint32_t>& face_part = {},
                                           const std::vector<std::string>& part_names = {}) {
  RawMesh mesh;
  mesh.face_part = face_part;
  mesh.part_names = part_names;
  for (const auto& face : faces) {
    std::vector<std::uint32_t> corners;
    for (const glm::dvec3& corner : face) {
      std::uint32_t index = 0;
      while (index < mesh.vertices.size() && mesh.vertices[index] != corner) ++index;
      if (index == mesh.vertices.size()) mesh.vertices.push_back(corner);
      corners.push_back(index);
    }
    mesh.faces.push_back(corners);
  }
  ImportOptions options;
  options.merge_coplanar = false;
  options.backdrop = false;
  return build_polygon_model(mesh, options);
}

/// An upright rectangle at distance z facing a camera that looks along +z, with y down as in the camera's frame.
[[nodiscard]] inline std::vector<glm::dvec3> facing_rectangle(double left, double top, double right, double bottom,
                                                              double z) {
  return {{left, top, z}, {left, bottom, z}, {right, bottom, z}, {right, top, z}};
}

[[nodiscard]] inline CameraModel pinhole(int width, int height, double focal_length) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.focal_length = {focal_length, focal_length};
  camera.principal_point = {width / 2.0, height / 2.0};
  return camera;
}

/// The camera's frame is the world's: it looks along +z, x right, y down.
[[nodiscard]] inline CaptureState at_origin(const PolygonModel& model) {
  CaptureState state;
  state.world_from_part.assign(model.parts().size(), Pose());
  return state;
}

}  // namespace foreview::oracle
