#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "foreview/recordings/synthetic/site.h"

namespace foreview::synthetic {

/// Puts solids into a site's mesh. Every solid is closed, its vertices are its own, its faces planar, convex and
/// counter-clockwise from outside. Positions are in the part's frame, metres.
class SiteBuilder {
 public:
  explicit SiteBuilder(Site& site) : site_(site) {}

  std::uint32_t part(const std::string& name, bool moves);
  std::uint32_t surface(const Surface& surface);
  [[nodiscard]] std::size_t face_count() const { return site_.mesh.faces.size(); }

  /// Faces put between these two belong to one free-standing thing.
  void begin_object();
  void end_object();

  /// Surfaces of a box's sides.
  struct BoxSurfaces {
    std::uint32_t front = 0, back = 0, left = 0, right = 0, top = 0, bottom = 0;  ///< -y, +y, -x, +x, +z, -z
    BoxSurfaces(std::uint32_t all) : front(all), back(all), left(all), right(all), top(all), bottom(all) {}
    BoxSurfaces(std::uint32_t sides, std::uint32_t lids)
        : front(sides), back(sides), left(sides), right(sides), top(lids), bottom(lids) {}
  };
  /// A box from its centre and size, its sides cut into divisions.x, .y and .z tiles. `inward` turns it into a room.
  void box(std::uint32_t part, const Pose& part_from_box, const glm::dvec3& size, const BoxSurfaces& surfaces,
           const glm::ivec3& divisions = {1, 1, 1}, bool inward = false);

  /// A ring of a solid of revolution about z: radius and height of its lower rim; the last ring's surface is unused.
  struct Ring {
    double radius = 0, height = 0;
    std::uint32_t surface = 0;  ///< of the faces between this ring and the next
  };
  /// A prism-like solid with `sides` faces around; lids at both ends.
  void lathe(std::uint32_t part, const Pose& part_from_solid, const std::vector<Ring>& rings, int sides,
             std::uint32_t lower_lid, std::uint32_t upper_lid);
  /// A plain prism between two heights.
  void prism(std::uint32_t part, const Pose& part_from_solid, double radius, double from, double to, int sides,
             std::uint32_t wall, std::uint32_t lid);

 private:
  void add_face(std::uint32_t part, std::vector<std::uint32_t> corners, const FaceSurface& look);
  std::uint32_t add_vertex(const glm::dvec3& p);

  Site& site_;
  int object_ = -1, objects_ = 0;
};

/// A pose that turns about z and then moves.
[[nodiscard]] Pose placed(const glm::dvec3& position, double yaw = 0);

}  // namespace foreview::synthetic
