#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "foreview/recordings/synthetic/site_builder.h"

namespace foreview::synthetic {

/// The workcell's room and furniture, and what stands on it. World frame, metres.
class WorkcellThings {
 public:
  WorkcellThings(SiteBuilder& builder, std::uint32_t part);

  void build_shell(const glm::dvec3& room);
  /// Centre and size of the top, its height.
  void build_bench(const glm::dvec2& centre, const glm::dvec2& size, double height);
  /// Along the back wall from its front left corner.
  void build_shelf(const glm::dvec2& corner, double length);
  void build_side_rack();
  void build_machine();
  /// Stores further things where there is room until the site has exactly this many faces.
  void fill_up_to(std::size_t faces);

 private:
  void carton(const glm::dvec3& foot, const glm::dvec3& size, double yaw);
  void bin(const glm::dvec3& foot, const glm::dvec3& size, double yaw);
  void binder(const glm::dvec3& foot, const glm::dvec3& size);
  void bottle(const glm::dvec3& foot, double radius, double height, int sides);
  void can(const glm::dvec3& foot, double radius, double height, int sides);
  /// A mixed row of things along x on a board; returns nothing, fills `length`.
  void row(const glm::dvec3& start, double length, double depth, double headroom);
  [[nodiscard]] float dice();  ///< next of a fixed sequence, 0..1
  [[nodiscard]] glm::vec3 bright_colour();

  SiteBuilder& builder_;
  std::uint32_t part_;
  int rolled_ = 0;
};

}  // namespace foreview::synthetic
