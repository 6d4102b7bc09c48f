#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "foreview/recordings/synthetic/site.h"
#include "foreview/scene/camera_model.h"
#include "foreview/scene/pose.h"

namespace foreview::synthetic {

/// Renders a site on the CPU: four samples a pixel placed where the distorted lens puts them, one shading per pixel and
/// face, averaged surfaces, soft light. Surfaces and static light of a face are computed when it is first seen. All
/// members may be called from several threads; the result does not depend on the order.
class Renderer {
 public:
  explicit Renderer(const Site& site);  ///< the site must outlive the renderer
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// CV_8UC3 BGR of the camera's size; black where nothing is. `seconds` since the site's first instant.
  [[nodiscard]] cv::Mat render(const CameraModel& camera, const Pose& world_from_camera, double seconds) const;

  /// Faces that own at least one sample of the picture, ascending.
  [[nodiscard]] std::vector<std::uint32_t> visible_faces(const CameraModel& camera, const Pose& world_from_camera,
                                                         double seconds) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview::synthetic
