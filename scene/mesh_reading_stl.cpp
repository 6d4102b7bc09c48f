#include <bit>
#include <cstring>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/mesh_reading.h"

namespace foreview {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies in memory");

constexpr std::size_t kHeader = 84;    // 80 bytes of comment, 4 of count
constexpr std::size_t kTriangle = 50;  // normal, three corners, two bytes of attributes

std::uint32_t announced_triangles(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  return count;
}

RawMesh parse_binary(std::string_view bytes, const std::string& where) {
  const std::uint64_t count = announced_triangles(bytes);
  const std::uint64_t there = (bytes.size() - kHeader) / kTriangle;
  if (there < count)
    throw InputError(where, "is cut off: a binary STL file of " + std::to_string(count) + " triangles, but only " +
                                std::to_string(there) + " are there");
  check_mesh_count(count, kMaxMeshFaces, "faces", where);
  if (count == 0) throw InputError(where, "has no triangle; expected an STL file with triangles");
  RawMesh mesh;
  mesh.vertices.reserve(3 * count);
  mesh.faces.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 9> numbers{};
    std::memcpy(numbers.data(), bytes.data() + kHeader + i * kTriangle + 12, sizeof(numbers));
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t k = 0; k < 9; k += 3) mesh.vertices.emplace_back(numbers[k], numbers[k + 1], numbers[k + 2]);
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

RawMesh parse_text(std::string_view bytes, const std::string& where) {
  RawMesh mesh;
  PartNames parts(mesh.part_names);
  TextScanner scanner(bytes, where);
  std::uint32_t part = 0;
  bool in_solid = false;
  bool in_loop = false;
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.word();
    if (keyword.empty()) continue;
    if (keyword == "solid" && !in_solid) {
      const std::string_view name = scanner.rest_of_line();
      part = parts.index(name.empty() ? "model" : name, where);
      in_solid = true;
    } else if (keyword == "outer" && in_solid && !in_loop) {
      mesh.faces.emplace_back();
      mesh.face_part.push_back(part);
      check_mesh_count(mesh.faces.size(), kMaxMeshFaces, "faces", where);
      in_loop = true;
    } else if (keyword == "vertex" && in_loop) {
      glm::dvec3 p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = scanner.number("a vertex's coordinate");
      mesh.faces.back().push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back(p);
      check_mesh_count(mesh.vertices.size(), kMaxMeshCorners, "vertices", where);
    } else if (keyword == "endloop" && in_loop) {
      in_loop = false;
    } else if (keyword == "endsolid" && in_solid && !in_loop) {
      in_solid = false;
    } else if (!((keyword == "facet" || keyword == "endfacet") && in_solid && !in_loop)) {
      scanner.fail(in_quotes(keyword) +
                   " stands where no such line is allowed; expected facet, outer loop, vertex, endloop, endfacet or "
                   "endsolid in their order");
    }
  }
  if (in_solid) throw InputError(where, "is cut off: \"endsolid\" is missing at its end");
  if (mesh.faces.empty()) throw InputError(where, "has no facet; expected an STL file with triangles");
  return mesh;
}

}  // namespace

// Equal vertices of different triangles become one in build_polygon_model().
RawMesh parse_stl(std::string_view bytes, const std::string& where) {
  // Binary files may begin with "solid" too: the size decides first.
  if (bytes.size() >= kHeader && bytes.size() == kHeader + std::uint64_t{announced_triangles(bytes)} * kTriangle)
    return parse_binary(bytes, where);
  const bool says_solid = bytes.substr(0, 5) == "solid";
  if (says_solid && bytes.substr(0, 512).find('\0') == std::string_view::npos) return parse_text(bytes, where);
  if (bytes.size() < kHeader)
    throw InputError(where, "is neither a text (\"solid ...\") nor a binary STL file (at least 84 bytes)");
  return parse_binary(bytes, where);
}

}  // namespace foreview
