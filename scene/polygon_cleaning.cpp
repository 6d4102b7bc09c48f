#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

#include "foreview/scene/errors.h"
#include "foreview/scene/mesh_reading.h"
#include "foreview/scene/polygon_face.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {
namespace {

constexpr std::size_t kMaxFaceCorners = 1'000;
constexpr double kBackdropRadii = 100;  // distance of the far box: what moves within the scene hardly moves before it
constexpr double kFarthest = 1e9;       // metres: beyond, squares of squares leave the range of doubles' accuracy

void check_limits(const RawMesh& mesh, const std::string& where) {
  check_mesh_count(mesh.faces.size(), kMaxMeshFaces, "faces", where);
  check_mesh_count(mesh.vertices.size(), kMaxMeshCorners, "vertices", where);
  check_mesh_count(mesh.part_names.size(), kMaxMeshParts, "parts", where);
  std::size_t corners = 0;
  for (const auto& face : mesh.faces) corners += face.size();
  check_mesh_count(corners, kMaxMeshCorners, "face corners", where);
  if (!mesh.face_part.empty() && mesh.face_part.size() != mesh.faces.size())
    throw InputError(where, "names a part for " + std::to_string(mesh.face_part.size()) + " of its " +
                                std::to_string(mesh.faces.size()) + " faces; expected all or none");
}

void check_options(const ImportOptions& options, const std::string& where) {
  const auto check = [&](bool good, const char* what, double value, const char* expected) {
    if (!good) throw InputError(where, std::string(what) + " is " + std::to_string(value) + ", expected " + expected);
  };
  check(options.scale > 0 && options.scale <= 1e9, "scale", options.scale, "metres per unit above 0, up to 1e9");
  check(options.planarity_tolerance >= 0 && options.planarity_tolerance <= 1e3, "planarity tolerance",
        options.planarity_tolerance, "metres from 0 to 1000");
  check(options.max_merged_extent >= 0, "largest merged extent", options.max_merged_extent, "metres from 0");
  check(options.weld_distance == 0 || (options.weld_distance >= 1e-9 && options.weld_distance <= 1e9), "weld distance",
        options.weld_distance, "0, or metres from 1e-9");
  if (!options.backdrop) return;
  check(options.backdrop_texels_per_radian > 0 && options.backdrop_texels_per_radian <= 1e5,
        "backdrop texels per radian", options.backdrop_texels_per_radian, "above 0, up to 100000");
  check(options.backdrop_max_texels >= 16 && options.backdrop_max_texels <= 16384, "backdrop texels of one polygon",
        options.backdrop_max_texels, "from 16 to 16384");
  check(2 * options.backdrop_texels_per_radian <= 100.0 * options.backdrop_max_texels, "backdrop texels of one polygon",
        options.backdrop_max_texels, "at least a fiftieth of the texels per radian");
}

std::uint64_t mix(std::uint64_t h) {
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
  return h ^ (h >> 31);
}

struct WordsHash {
  template <typename Words>
  std::size_t operator()(const Words& words) const {
    std::uint64_t h = words.size();
    for (const auto word : words) h = mix(h + 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(word));
    return static_cast<std::size_t>(h);
  }
};

struct WordHash {
  std::size_t operator()(std::uint64_t word) const { return static_cast<std::size_t>(mix(word)); }
};

bool is_usable(const glm::dvec3& p) {
  // Written so that NaN fails.
  return std::abs(p.x) <= kFarthest && std::abs(p.y) <= kFarthest && std::abs(p.z) <= kFarthest;
}

/// Makes one vertex of those of one part that are equal or closer than the weld distance: the first one stays.
class Welder {
 public:
  Welder(double distance, std::vector<glm::dvec3>& vertices) : distance_(distance), vertices_(vertices) {}

  std::uint32_t weld(const glm::dvec3& p, std::uint32_t part) {
    const Key key = cell(p, part);
    if (distance_ == 0) {
      const auto [place, is_new] = exact_.try_emplace(key, static_cast<std::uint32_t>(vertices_.size()));
      if (is_new) vertices_.push_back(p);
      return place->second;
    }
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        for (std::int64_t z = -1; z <= 1; ++z) {
          const auto range = near_.equal_range(Key{key[0] + x, key[1] + y, key[2] + z, key[3]});
          for (auto i = range.first; i != range.second; ++i)
            if (glm::distance(vertices_[i->second], p) < distance_) return i->second;
        }
      }
    }
    near_.emplace(key, static_cast<std::uint32_t>(vertices_.size()));
    vertices_.push_back(p);
    return static_cast<std::uint32_t>(vertices_.size() - 1);
  }

 private:
  using Key = std::array<std::int64_t, 4>;
  Key cell(const glm::dvec3& p, std::uint32_t part) const {
    Key key{0, 0, 0, part};
    for (int axis = 0; axis < 3; ++axis) {
      key[static_cast<std::size_t>(axis)] = distance_ == 0 ? std::bit_cast<std::int64_t>(p[axis] + 0.0)  // -0 becomes 0
                                                           : static_cast<std::int64_t>(std::floor(p[axis] / distance_));
    }
    return key;
  }
  double distance_;
  std::vector<glm::dvec3>& vertices_;
  std::unordered_map<Key, std::uint32_t, WordsHash> exact_;
  std::unordered_multimap<Key, std::uint32_t, WordsHash> near_;
};

/// Drops corners that repeat the one before, and whiskers (there and back again).
void tidy_outline(std::vector<std::uint32_t>& corners) {
  std::vector<std::uint32_t> kept;
  for (const std::uint32_t corner : corners) {
    if (!kept.empty() && kept.back() == corner) continue;
    if (kept.size() >= 2 && kept[kept.size() - 2] == corner) {
      kept.pop_back();
      continue;
    }
    kept.push_back(corner);
  }
  // The same where the outline closes.
  std::size_t first = 0;
  while (kept.size() - first >= 2) {
    const std::size_t last = kept.size() - 1;
    if (kept[first] == kept[last]) {
      kept.pop_back();
    } else if (kept.size() - first >= 3 && kept[first] == kept[last - 1]) {
      kept.resize(last - 1);
    } else if (kept.size() - first >= 3 && kept[first + 1] == kept[last]) {
      ++first;
      kept.pop_back();
    } else {
      break;
    }
  }
  corners.assign(kept.begin() + static_cast<std::ptrdiff_t>(first), kept.end());
}

class Cleaner {
 public:
  Cleaner(const RawMesh& mesh, const ImportOptions& options, ImportReport& report)
      : mesh_(mesh), options_(options), report_(report), welder_(options.weld_distance, vertices) {}

  std::vector<glm::dvec3> vertices;
  std::vector<Face> faces;

  void run() {
    std::vector<std::uint32_t> corners;
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
      const std::uint32_t part = mesh_.face_part.empty() ? 0 : mesh_.face_part[f];
      if (!take_corners(mesh_.faces[f], part, corners)) continue;
      tidy_outline(corners);
      if (corners.size() < 3) {
        ++report_.faces_degenerate;
        continue;
      }
      const std::size_t before = faces.size();
      const SplitOutcome outcome = split_into_convex(vertices, corners, part, options_.planarity_tolerance,
                                                     0.01 * options_.planarity_tolerance, faces);
      if (outcome.degenerate) {
        ++report_.faces_degenerate;
        continue;
      }
      if (is_duplicate(corners)) {
        faces.resize(before);
        ++report_.faces_duplicate;
        continue;
      }
      report_.faces_split_not_planar += outcome.not_planar ? 1 : 0;
      report_.faces_split_concave += outcome.concave ? 1 : 0;
      report_.faces_self_crossing += outcome.self_crossing ? 1 : 0;
    }
    report_.vertices_welded = seen_.size() - vertices.size();
  }

 private:
  bool take_corners(const std::vector<std::uint32_t>& face, std::uint32_t part, std::vector<std::uint32_t>& corners) {
    const std::size_t parts = std::max<std::size_t>(1, mesh_.part_names.size());
    const bool indices_good =
        part < parts && std::all_of(face.begin(), face.end(), [&](auto i) { return i < mesh_.vertices.size(); });
    if (!indices_good) {
      ++report_.faces_with_bad_index;
      return false;
    }
    if (face.size() > kMaxFaceCorners) {
      ++report_.faces_too_complex;
      return false;
    }
    for (const std::uint32_t i : face) {
      if (is_usable(mesh_.vertices[i] * options_.scale)) continue;
      ++report_.faces_not_finite;
      return false;
    }
    corners.clear();
    for (const std::uint32_t i : face) {
      const auto [place, is_new] = seen_.try_emplace((std::uint64_t{part} << 32) | i, 0U);
      if (is_new) place->second = welder_.weld(mesh_.vertices[i] * options_.scale, part);
      corners.push_back(place->second);
    }
    return true;
  }

  bool is_duplicate(std::vector<std::uint32_t> corners) {
    std::sort(corners.begin(), corners.end());
    return !known_.insert(std::move(corners)).second;
  }

  const RawMesh& mesh_;
  const ImportOptions& options_;
  ImportReport& report_;
  Welder welder_;
  std::unordered_map<std::uint64_t, std::uint32_t, WordHash> seen_;  // part and vertex of the file -> vertex
  std::unordered_set<std::vector<std::uint32_t>, WordsHash> known_;
};

/// One line each for what a person should look at.
void write_warnings(ImportReport& report) {
  const auto warn = [&](std::size_t count, const std::string& text) {
    if (count > 0) report.warnings.push_back(std::to_string(count) + " " + text);
  };
  const glm::dvec3 size = report.bounds_max - report.bounds_min;
  const double largest = std::max({size.x, size.y, size.z});
  if (largest > 1000)
    report.warnings.push_back("the model is " + std::to_string(std::lround(largest)) +
                              " m wide: is the scale right? (millimetres want scale 0.001)");
  if (largest < 0.01)
    report.warnings.push_back("the model is only " + std::to_string(largest * 1000) + " mm wide: is the scale right?");
  warn(report.faces_with_bad_index, "faces dropped: a corner's index is out of range");
  warn(report.faces_not_finite, "faces dropped: a corner is not a finite number (or beyond 1e9 m)");
  warn(report.faces_degenerate, "faces dropped: no area");
  warn(report.faces_duplicate, "faces dropped: same corners as an earlier face");
  warn(report.faces_too_complex, "faces dropped: more than 1000 corners; triangulate them");
  warn(report.faces_self_crossing, "faces cross themselves: parts of them may be missing");
  warn(report.edges_with_opposed_winding,
       "edges between faces of opposed winding: one of each pair shows its back where it should show its front");
  warn(report.edges_not_manifold, "edges have three or more faces: cut apart");
  if (report.boundary_loops > 0)
    report.warnings.push_back(std::to_string(report.boundary_loops) + " holes or rims of " +
                              std::to_string(report.boundary_edges) + " edges: cameras see through them");
}

/// Merges, and gives the pairs of neighbours among the results.
void merge_coplanar(const std::vector<glm::dvec3>& vertices, std::vector<Face>& faces,
                    std::vector<std::pair<std::uint32_t, std::uint32_t>>& adjacent, const ImportOptions& options,
                    ImportReport& report) {
  const MergeLimits limits{options.planarity_tolerance, 0.01 * options.planarity_tolerance, options.max_merged_extent,
                           true};
  const std::vector<std::uint32_t> result = merge_faces(vertices, faces, limits);
  std::vector<std::uint32_t> members(faces.size(), 0);
  for (const std::uint32_t r : result) ++members[r];
  for (const std::uint32_t count : members) report.faces_merged += count > 1 ? count : 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> merged;
  for (const auto& [a, b] : adjacent)
    if (result[a] != result[b]) merged.emplace_back(std::min(result[a], result[b]), std::max(result[a], result[b]));
  std::sort(merged.begin(), merged.end());
  merged.erase(std::unique(merged.begin(), merged.end()), merged.end());
  adjacent = std::move(merged);
}

}  // namespace

struct PolygonModelBuilder {
  PolygonModel model;

  /// Keeps only the vertices that are used, in the order of their use.
  void add_faces(const std::vector<glm::dvec3>& vertices, const std::vector<Face>& faces, bool backdrop,
                 double texels_per_metre) {
    std::vector<std::uint32_t> place(vertices.size(), ~0U);
    for (const Face& face : faces) {
      Polygon polygon;
      polygon.first_corner = static_cast<std::uint32_t>(model.corners_.size());
      polygon.corner_count = static_cast<std::uint32_t>(face.corners.size());
      polygon.part = face.part;
      polygon.normal = face.plane.normal;
      polygon.offset = face.plane.offset;
      polygon.is_backdrop = backdrop;
      polygon.texels_per_metre = texels_per_metre;
      for (const std::uint32_t corner : face.corners) {
        if (place[corner] == ~0U) {
          place[corner] = static_cast<std::uint32_t>(model.vertices_.size());
          model.vertices_.push_back(vertices[corner]);
        }
        model.corners_.push_back(place[corner]);
      }
      model.polygons_.push_back(polygon);
    }
  }

  /// `pairs`: each pair of neighbours once.
  void set_neighbours(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
    std::vector<std::uint32_t>& first = model.first_neighbour_;
    first.assign(model.polygons_.size() + 1, 0);
    for (const auto& [a, b] : pairs) {
      ++first[a + 1];
      ++first[b + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    model.neighbours_.resize(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (const auto& [a, b] : pairs) {
      model.neighbours_[next[a]++] = b;
      model.neighbours_[next[b]++] = a;
    }
    for (std::size_t i = 0; i + 1 < first.size(); ++i)
      std::sort(model.neighbours_.begin() + first[i], model.neighbours_.begin() + first[i + 1]);
  }

  void add_parts(const RawMesh& mesh, bool backdrop, ImportReport& report) {
    for (const std::string& name : mesh.part_names) model.parts_.push_back({name});
    if (model.parts_.empty()) model.parts_.push_back({"model"});
    if (!backdrop) return;
    for (Part& part : model.parts_) {
      if (part.name != "backdrop") continue;
      part.name = "backdrop (file)";
      report.warnings.emplace_back(
          "the file's part \"backdrop\" is called \"backdrop (file)\": the far box has its name");
    }
    model.parts_.push_back({"backdrop"});
  }
};

PolygonModel build_polygon_model(const RawMesh& mesh, const ImportOptions& options, ImportReport* report,
                                 const std::string& where) {
  ImportReport own;
  ImportReport& r = report != nullptr ? *report : own;
  r = {};
  check_options(options, where);
  check_limits(mesh, where);
  r.faces_in = mesh.faces.size();
  r.vertices_in = mesh.vertices.size();

  Cleaner cleaner(mesh, options, r);
  cleaner.run();
  std::vector<glm::dvec3>& vertices = cleaner.vertices;
  std::vector<Face>& faces = cleaner.faces;
  if (faces.empty())
    throw InputError(where, "has no usable face (" + std::to_string(r.faces_in) +
                                " faces: " + std::to_string(r.faces_with_bad_index) + " with an index out of range, " +
                                std::to_string(r.faces_not_finite) + " not finite, " +
                                std::to_string(r.faces_degenerate) + " without area, " +
                                std::to_string(r.faces_too_complex) + " too complex); expected at least one polygon");
  r.bounds_min = glm::dvec3(std::numeric_limits<double>::infinity());
  r.bounds_max = -r.bounds_min;
  for (const Face& face : faces) {
    for (const std::uint32_t corner : face.corners) {
      r.bounds_min = glm::min(r.bounds_min, vertices[corner]);
      r.bounds_max = glm::max(r.bounds_max, vertices[corner]);
    }
  }

  Topology topology = make_manifold(vertices, faces);
  r.vertices_split = topology.vertices_split;
  r.boundary_edges = topology.boundary_edges;
  r.boundary_loops = topology.boundary_loops;
  r.edges_with_opposed_winding = topology.opposed_edges;
  r.edges_not_manifold = topology.not_manifold_edges;
  r.median_edge = topology.median_edge;
  if (options.merge_coplanar) merge_coplanar(vertices, faces, topology.adjacent, options, r);

  PolygonModelBuilder builder;
  builder.add_parts(mesh, options.backdrop, r);
  builder.add_faces(vertices, faces, false, 0);
  r.polygons_out = faces.size();
  if (options.backdrop) {
    std::vector<glm::dvec3> far_vertices;
    std::vector<Face> far_faces;
    const double radius = std::max(1e-3, 0.5 * glm::distance(r.bounds_min, r.bounds_max));
    const auto part = static_cast<std::uint32_t>(builder.model.parts().size() - 1);
    const double density =
        append_backdrop(0.5 * (r.bounds_min + r.bounds_max), kBackdropRadii * radius,
                        options.backdrop_texels_per_radian, options.backdrop_max_texels, part, far_vertices, far_faces);
    const auto first = static_cast<std::uint32_t>(faces.size());
    for (const auto& [a, b] : make_manifold(far_vertices, far_faces).adjacent)
      topology.adjacent.emplace_back(first + a, first + b);
    builder.add_faces(far_vertices, far_faces, true, density);
    r.backdrop_polygons = far_faces.size();
    r.polygons_out += far_faces.size();
  }
  builder.set_neighbours(topology.adjacent);
  r.parts = builder.model.parts().size();
  write_warnings(r);
  return std::move(builder.model);
}

PolygonModel import_model(const std::filesystem::path& file, const ImportOptions& options, ImportReport* report) {
  return build_polygon_model(read_mesh(file), options, report, file.string());
}

}  // namespace foreview
