#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "foreview/scene/polygon_geometry.h"

namespace foreview {

/// A face on its way from a file to a polygon.
struct Face {
  std::vector<std::uint32_t> corners;  ///< indices of vertices, counter-clockwise seen from the front
  std::uint32_t part = 0;
  Plane plane;
};

/// A face thinner than this is degenerate: float coordinates of a room resolve no less. Metres.
inline constexpr double kLeastHeight = 1e-7;

/// Copies a face's corner points into `points`.
void gather_corners(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> corners,
                    std::vector<glm::dvec3>& points);

/// What becomes of one outline when it is taken apart.
struct SplitOutcome {
  bool degenerate = false, not_planar = false, concave = false, self_crossing = false;
};

/// Appends the convex planar pieces of a face (distinct consecutive corners, at least three) to `pieces`. A planar
/// face's pieces keep its plane; others are triangles, joined where that stays planar and convex. Tolerances in metres.
SplitOutcome split_into_convex(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> corners,
                               std::uint32_t part, double planarity, double convexity, std::vector<Face>& pieces);

struct MergeLimits {
  double planarity = 1e-3;   ///< metres a corner may lie off the common plane
  double convexity = 1e-5;   ///< metres, see is_convex()
  double max_extent = 0.5;   ///< metres, longer side of the result's smallest box
  bool drop_corners = true;  ///< drop corners on a straight edge that no other face uses
};

/// Joins neighbours of one part, across edges that exactly two faces use in opposite directions, as long as the result
/// is convex, planar and not too wide; longest edges first, so that the diagonals of quadrilaterals go before their
/// sides. Faces tilted by more than 2 degrees are never joined, however small they are. `faces` becomes the result
/// (in the order of each result's first face); returned: the result that each input face went into.
std::vector<std::uint32_t> merge_faces(std::span<const glm::dvec3> vertices, std::vector<Face>& faces,
                                       const MergeLimits& limits);

struct Topology {
  /// Pairs of faces that share an edge, cut apart or not.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> adjacent;
  std::size_t vertices_split = 0, boundary_edges = 0, boundary_loops = 0, opposed_edges = 0, not_manifold_edges = 0;
  double median_edge = 0;
};

/// Makes the faces an oriented manifold with boundary by giving faces vertices of their own where they meet only in a
/// corner, in an edge of three or more faces, or with opposed windings. New vertices are appended.
Topology make_manifold(std::vector<glm::dvec3>& vertices, std::vector<Face>& faces);

/// The far box of design 4: faces look inwards, appended with `part`; returns the texels per metre that its polygons
/// must have. Distances are from `centre`, which sees every side at `distance`.
double append_backdrop(const glm::dvec3& centre, double distance, double texels_per_radian, int max_texels,
                       std::uint32_t part, std::vector<glm::dvec3>& vertices, std::vector<Face>& faces);

}  // namespace foreview
