#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "foreview/recordings/synthetic/site.h"

namespace foreview::synthetic {

/// Display colour (RGB, 0..1, before light) of a surface at (u, v) metres on a side of `size` metres; see FaceSurface.
/// Nothing changes over less than about 4 mm, so that 500 texels/m hold all of it.
[[nodiscard]] glm::vec3 surface_colour(const Surface& surface, const glm::vec2& uv, const glm::vec2& size);

}  // namespace foreview::synthetic
