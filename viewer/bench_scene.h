#pragma once
#include <cstddef>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/viewer/bench_pictures.h"

namespace foreview {

/// A closed room with bumpy walls, some 6 m wide, whose fronts face inwards: a cube's sides of 2 k^2 triangles each,
/// blown up to a sphere of uneven radius, with k such that the number of polygons is the nearest there is to the one
/// asked for (12 k^2). One part, no backdrop. The same for the same number.
[[nodiscard]] PolygonModel bumpy_room(std::size_t polygons);

/// A camera of about `megapixels` with sides of 4:3 and a horizontal field of view of 60 degrees, without distortion.
[[nodiscard]] CameraModel room_camera(double megapixels);

/// `count` pictures of that camera, turning once around near the room's middle: what they show does not matter to the
/// cost, so all show the same pattern.
[[nodiscard]] BenchPictures room_pictures(const CameraModel& camera, std::size_t count);

}  // namespace foreview
