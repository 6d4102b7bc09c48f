#include <cctype>

#include "foreview/scene/errors.h"
#include "foreview/scene/mesh_reading.h"

namespace foreview {

RawMesh parse_off(std::string_view bytes, const std::string& where) {
  TextScanner scanner(bytes, where);
  if (!scanner.next_line_with_words()) throw InputError(where, "is empty; expected an OFF file");
  // [ST][C][N][4][n]OFF: what stands before OFF are further numbers per vertex, behind its coordinates.
  std::string_view keyword = scanner.word();
  const bool known = keyword == "OFF" || keyword == "COFF" || keyword == "NOFF" || keyword == "CNOFF" ||
                     keyword == "STOFF" || keyword == "STCOFF" || keyword == "STNOFF" || keyword == "STCNOFF";
  if (!known)
    scanner.fail("does not begin with OFF (or COFF, NOFF, ...); expected a text OFF file in three dimensions");
  // Normals come before colours and texture coordinates, and all of them behind x y z: nothing else is needed.
  std::string_view rest = scanner.rest_of_line();
  if (rest.substr(0, 6) == "BINARY") scanner.fail("is a binary OFF file; expected a text OFF file");
  if (rest.empty() && !scanner.next_line_with_words()) scanner.fail("ends where the counts were expected");
  const auto vertices = scanner.integer<std::uint64_t>("the number of vertices");
  const auto faces = scanner.integer<std::uint64_t>("the number of faces");
  check_mesh_count(vertices, kMaxMeshCorners, "vertices", where);
  check_mesh_count(faces, kMaxMeshFaces, "faces", where);

  RawMesh mesh;
  for (std::uint64_t i = 0; i < vertices; ++i) {
    if (!scanner.next_line_with_words())
      scanner.fail("ends after " + std::to_string(i) + " of " + std::to_string(vertices) + " vertices");
    glm::dvec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = scanner.number("a vertex's coordinate");
    mesh.vertices.push_back(p);
  }
  std::size_t corners = 0;
  for (std::uint64_t i = 0; i < faces; ++i) {
    if (!scanner.next_line_with_words())
      scanner.fail("ends after " + std::to_string(i) + " of " + std::to_string(faces) + " faces");
    const auto count = scanner.integer<std::uint32_t>("a face's number of corners");
    corners += count;
    check_mesh_count(corners, kMaxMeshCorners, "face corners", where);
    std::vector<std::uint32_t>& face = mesh.faces.emplace_back();
    for (std::uint32_t k = 0; k < count; ++k) {
      const auto index = scanner.integer<std::int64_t>("a face's corner");
      face.push_back(index < 0 || index > std::int64_t{0xfffffffe} ? ~0U : static_cast<std::uint32_t>(index));
    }
  }
  if (mesh.faces.empty()) throw InputError(where, "has no face; expected an OFF file with faces");
  return mesh;
}

}  // namespace foreview
