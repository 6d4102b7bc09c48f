#include "oracle/visibility.h"

#include <algorithm>

#include "oracle/projection.h"

namespace foreview::oracle {

Visibility visibility(const PolygonModel& model, const CameraModel& camera, const CaptureState& state,
                      double near_plane) {
  Visibility result;
  result.nearest = Image<Hit>(camera.width, camera.height);
  result.candidates = Image<std::vector<Hit>>(camera.width, camera.height);
  AlphaImage surely(camera.width, camera.height, 0.0);  // largest 1/z of what certainly covers the pixel's centre
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const ProjectedPolygon polygon = project(model, i, camera, state, near_plane);
    for (int y = polygon.grown_box.top; y < polygon.grown_box.bottom; ++y) {
      for (int x = polygon.grown_box.left; x < polygon.grown_box.right; ++x) {
        const glm::dvec2 centre{x + 0.5, y + 0.5};
        const double distance = polygon.signed_distance(centre);
        if (distance < -kEdgeRounding) continue;
        const Hit hit{static_cast<int>(i), polygon.inverse_z(centre)};
        if (!(hit.inverse_z > 0)) continue;
        if (distance >= 0 && hit.inverse_z > result.nearest.at(x, y).inverse_z) result.nearest.at(x, y) = hit;
        if (distance > kEdgeRounding) surely.at(x, y) = std::max(surely.at(x, y), hit.inverse_z);
        result.candidates.at(x, y).push_back(hit);
      }
    }
  }
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      auto& candidates = result.candidates.at(x, y);
      const double least = surely.at(x, y) * (1 - 1e-5);
      std::erase_if(candidates, [&](const Hit& hit) { return hit.inverse_z < least; });
      if (surely.at(x, y) == 0) candidates.emplace_back();
    }
  }
  return result;
}

}  // namespace foreview::oracle
