#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "foreview/scene/polygon_face.h"

namespace foreview {

double append_backdrop(const glm::dvec3& centre, double distance, double texels_per_radian, int max_texels,
                       std::uint32_t part, std::vector<glm::dvec3>& vertices, std::vector<Face>& faces) {
  // At a face's centre one radian is `distance` long, and a side of the cube is two of them.
  const int cells = std::max(1, static_cast<int>(std::ceil(2 * texels_per_radian / max_texels - 1e-9)));
  // Lattice points on the cube's surface, so that cells share corners across its edges too.
  std::map<std::array<int, 3>, std::uint32_t> index;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [place, is_new] = index.try_emplace(at, static_cast<std::uint32_t>(vertices.size()));
    if (is_new) {
      glm::dvec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = centre[axis] + distance * (2.0 * at[static_cast<std::size_t>(axis)] / cells - 1);
      vertices.push_back(p);
    }
    return place->second;
  };
  std::vector<glm::dvec3> points;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u_axis = (axis + 1) % 3;
    const std::size_t v_axis = (axis + 2) % 3;
    for (const int side : {0, 1}) {
      glm::dvec3 normal(0);
      normal[static_cast<int>(axis)] = side == 0 ? 1 : -1;  // inwards
      for (int v = 0; v < cells; ++v) {
        for (int u = 0; u < cells; ++u) {
          const auto corner = [&](int du, int dv) {
            std::array<int, 3> at{};
            at[axis] = side * cells;
            at[u_axis] = u + du;
            at[v_axis] = v + dv;
            return vertex(at);
          };
          Face face;
          face.part = part;
          // Counter-clockwise about +axis, the other way round on the far side.
          face.corners = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (side == 1) std::reverse(face.corners.begin() + 1, face.corners.end());
          gather_corners(vertices, face.corners, points);
          face.plane = plane_midway(points, normal);
          faces.push_back(std::move(face));
        }
      }
    }
  }
  return max_texels * cells / (2 * distance);
}

}  // namespace foreview
