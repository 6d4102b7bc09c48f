#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "foreview/scene/pose.h"

namespace foreview {

/// A rigid part: its polygons move together. Part 0 always exists.
struct Part {
  std::string name;
};

/// A convex planar polygon, in its part's frame.
struct Polygon {
  std::uint32_t first_corner = 0;  ///< into PolygonModel::corners()
  std::uint32_t corner_count = 0;  ///< >= 3, counter-clockwise seen from the front
  std::uint32_t part = 0;
  glm::dvec3 normal{0, 0, 1};   ///< unit length, out of the front
  double offset = 0;            ///< dot(normal, p) == offset on the plane, metres
  bool is_backdrop = false;     ///< a face of the far box (design 4): never an occluder's surface, only the last resort
  double texels_per_metre = 0;  ///< fixed by the import (backdrop: per radian over distance); 0: ChartOptions decide
};

/// The polygon model of the remote site: immutable, made by build_polygon_model().
class PolygonModel {
 public:
  [[nodiscard]] std::span<const glm::dvec3> vertices() const { return vertices_; }   ///< part frames, metres
  [[nodiscard]] std::span<const std::uint32_t> corners() const { return corners_; }  ///< indices of vertices
  [[nodiscard]] std::span<const Polygon> polygons() const { return polygons_; }
  [[nodiscard]] std::span<const Part> parts() const { return parts_; }
  /// Indices of the polygon's corners, in order.
  [[nodiscard]] std::span<const std::uint32_t> corners_of(std::size_t polygon) const;
  [[nodiscard]] const glm::dvec3& corner(std::size_t polygon, std::size_t i) const;
  /// Polygons that share an edge with this one (across cut non-manifold places too), ascending, without itself.
  [[nodiscard]] std::span<const std::uint32_t> neighbours_of(std::size_t polygon) const;
  /// The part with this name, or -1.
  [[nodiscard]] int part_index(const std::string& name) const;
  /// Changes with anything that textures depend on: geometry, parts, order. Same on every machine.
  [[nodiscard]] std::uint64_t fingerprint() const;

 private:
  friend struct PolygonModelBuilder;
  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> corners_;
  std::vector<Polygon> polygons_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> neighbours_;
  std::vector<std::uint32_t> first_neighbour_;  ///< polygons + 1 entries
};

/// Faces as a file or a generator gives them: anything goes.
struct RawMesh {
  std::vector<glm::dvec3> vertices;               ///< in the frame of the part that uses them, metres
  std::vector<std::vector<std::uint32_t>> faces;  ///< corner lists, any length, may be concave or not planar
  std::vector<std::uint32_t> face_part;           ///< one per face, or empty: all in part 0
  std::vector<std::string> part_names;            ///< empty: one part, "model"
};

struct ImportOptions {
  double scale = 1.0;                 ///< metres per unit of the file
  bool merge_coplanar = true;         ///< join coplanar neighbours where that stays convex ...
  double max_merged_extent = 0.5;     ///< ... and no wider than this, metres: a larger polygon would get coarser texels
  double planarity_tolerance = 1e-3;  ///< metres a corner may be off its polygon's plane before the face is split
  double weld_distance = 0.0;         ///< metres; vertices of one part closer than this become one. 0: only equal ones
  bool backdrop = true;               ///< put a far box around the scene (design 4), as the last part, "backdrop"
  double backdrop_texels_per_radian = 600;
  int backdrop_max_texels = 256;  ///< of one backdrop polygon along an axis: decides how often a side is subdivided
};

/// What the importer did and what looks wrong. Every dropped or changed face is counted.
struct ImportReport {
  std::size_t faces_in = 0, vertices_in = 0;
  std::size_t polygons_out = 0, backdrop_polygons = 0, parts = 0;
  std::size_t faces_with_bad_index = 0;  ///< dropped: index out of range
  std::size_t faces_not_finite = 0;      ///< dropped: NaN, infinite, or a corner beyond 1e9 m
  std::size_t faces_degenerate = 0;      ///< dropped: fewer than three distinct corners, or (almost) no area
  std::size_t faces_duplicate = 0;       ///< dropped: same corners as an earlier face, either winding
  std::size_t faces_too_complex = 0;     ///< dropped: more than 1,000 corners
  std::size_t faces_self_crossing = 0;   ///< outline crosses itself: kept as far as it could be taken apart
  std::size_t faces_split_not_planar = 0, faces_split_concave = 0;
  std::size_t faces_merged = 0;                         ///< faces that became part of a larger polygon
  std::size_t vertices_welded = 0, vertices_split = 0;  ///< split: non-manifold places cut apart
  std::size_t boundary_edges = 0;                       ///< edges with one polygon: holes and rims
  std::size_t boundary_loops = 0;
  std::size_t edges_with_opposed_winding = 0;  ///< neighbours whose fronts disagree
  std::size_t edges_not_manifold = 0;          ///< edges with three and more polygons: cut, neighbours still known
  glm::dvec3 bounds_min{0}, bounds_max{0};     ///< without the backdrop, metres, part frames
  double median_edge = 0;                      ///< metres
  std::vector<std::string> warnings;           ///< one line each: scale, winding, holes, duplicates ...
};

/// Cleans faces into convex planar polygons. Convex up to a hundredth of planarity_tolerance, planar up to
/// planarity_tolerance; corners stay where the mesh has them. Throws InputError (at `where`) if no polygon is left, an
/// option is out of its range, or there are more than 2 million faces or 8 million corners or vertices.
[[nodiscard]] PolygonModel build_polygon_model(const RawMesh& mesh, const ImportOptions& options,
                                               ImportReport* report = nullptr, const std::string& where = "mesh");

/// Reads OBJ, PLY, STL, OFF (in double precision, polygons as they are) and, through assimp, glTF/GLB, DAE and what
/// else assimp knows. Objects, groups or nodes become parts by name (OBJ groups only where the file names no objects);
/// a node's transform is baked into its vertices. glTF and DAE come in metres; others as they are. Throws InputError
/// naming the file.
[[nodiscard]] RawMesh read_mesh(const std::filesystem::path& file);
[[nodiscard]] PolygonModel import_model(const std::filesystem::path& file, const ImportOptions& options,
                                        ImportReport* report = nullptr);
/// Writes a RawMesh as Wavefront OBJ, parts as objects, numbers with enough digits to read back the same mesh.
void write_obj(const RawMesh& mesh, const std::filesystem::path& file);

/// The plane frame of spec 6 (eq. 4.24-4.27): origin so that all coordinates are >= 0, y along an edge, x = y cross n.
/// Of the polygon's edges, the one that gives the smallest box is taken; ties go to the first. (Of more than 256 edges
/// only every n-th is tried.)
struct PolygonFrame {
  glm::dvec3 origin{0}, x_axis{1, 0, 0}, y_axis{0, 1, 0};  ///< part frame
  glm::dvec2 extent{0, 0};                                 ///< metres, of the polygon's box in this frame
  [[nodiscard]] glm::dvec2 plane_from_part(const glm::dvec3& p) const;
  [[nodiscard]] glm::dvec3 part_from_plane(const glm::dvec2& q) const;
};
[[nodiscard]] PolygonFrame polygon_frame(const PolygonModel& model, std::size_t polygon);

/// The middle of the box around each part's polygons, part frame; the origin for a part without any. Positions relative
/// to it fit into floats.
[[nodiscard]] std::vector<glm::dvec3> centres_of_parts(const PolygonModel& model);

}  // namespace foreview
