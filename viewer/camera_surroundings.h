#pragma once
#include <glm/vec3.hpp>
#include <span>

#include "foreview/scene/polygon_model.h"
#include "foreview/scene/pose.h"

namespace foreview {

/// What the operator's camera moves in.
struct CameraSurroundings {
  glm::dvec3 centre{0};    ///< world, metres: of a ball around the scene (without its backdrop)
  double radius = 1;       ///< metres
  glm::dvec3 up{0, 0, 1};  ///< world, unit length
};
/// The ball around the model as the parts lie; or, where that is much smaller, around four fifths of the polygons in
/// the middle of what the cameras see: a room's walls are far around what happens in it. `up` is the world's axis that
/// the cameras hold upright, else (a camera that mostly looks along it) +z.
[[nodiscard]] CameraSurroundings find_surroundings(const PolygonModel& model, std::span<const Pose> world_from_part,
                                                   std::span<const Pose> world_from_cameras);

}  // namespace foreview
