#pragma once
#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"

namespace foreview::oracle {

/// A small scene that has a bit of everything that extraction must cope with: a floor that begins behind the camera, a
/// box whose faces share edges, a bent strip of triangles, single convex polygons in all directions (back faces too),
/// a moving part, some of it outside the picture. The same for the same seed.
struct RandomScene {
  PolygonModel model;
  CameraFrame frame;
};
[[nodiscard]] RandomScene random_scene(unsigned seed, DistortionModel distortion, bool backdrop);

/// The scene a moment later: camera and moving part elsewhere, other noise in the picture.
[[nodiscard]] CameraFrame moved(const RandomScene& scene, unsigned seed, Timestamp stamp);

}  // namespace foreview::oracle
