#include <string>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/mesh_reading.h"

namespace foreview {
namespace {

/// Faces split over lines by a backslash are rare, but legal.
std::string join_continued_lines(std::string_view bytes) {
  std::string text(bytes);
  for (std::size_t at = text.find('\\'); at != std::string::npos; at = text.find('\\', at + 1)) {
    std::size_t end = at + 1;
    if (end < text.size() && text[end] == '\r') ++end;
    if (end < text.size() && text[end] == '\n')
      for (std::size_t i = at; i <= end; ++i) text[i] = ' ';
  }
  return text;
}

/// A corner is "v", "v/vt", "v/vt/vn" or "v//vn"; v counts from 1, or from the end if negative.
std::uint32_t corner_index(std::string_view word, std::size_t vertices, const TextScanner& scanner) {
  std::int64_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error != std::errc() || (end != word.data() + word.size() && *end != '/') || index == 0)
    scanner.fail("a face has the corner " + in_quotes(word) +
                 "; expected a vertex number as in \"f 1 2 3\" or \"f 1/1/1 2/2/2 3/3/3\"");
  if (index < 0) index += static_cast<std::int64_t>(vertices) + 1;
  // Out of range both ways is left to cleaning, which drops and counts the face.
  return index < 1 || index > std::int64_t{0xffffffff} ? ~0U : static_cast<std::uint32_t>(index - 1);
}

}  // namespace

RawMesh parse_obj(std::string_view bytes, const std::string& where) {
  const bool continued = bytes.find("\\\n") != std::string_view::npos || bytes.find("\\\r") != std::string_view::npos;
  const std::string joined = continued ? join_continued_lines(bytes) : std::string();
  const std::string_view text = continued ? std::string_view(joined) : bytes;

  // Groups within an object would tear it apart.
  bool has_objects = false;
  for (TextScanner scanner(text, where); !has_objects && scanner.next_line_with_words();)
    has_objects = scanner.word() == "o";

  RawMesh mesh;
  PartNames parts(mesh.part_names);
  std::string part_name = "model";
  std::size_t corners = 0;
  TextScanner scanner(text, where);
  while (scanner.next_line_with_words()) {
    const std::string_view keyword = scanner.word();
    if (keyword == "v") {
      glm::dvec3 p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = scanner.number("a vertex's coordinate");
      mesh.vertices.push_back(p);
      check_mesh_count(mesh.vertices.size(), kMaxMeshCorners, "vertices", where);
    } else if (keyword == "f") {
      std::vector<std::uint32_t>& face = mesh.faces.emplace_back();
      for (std::string_view word = scanner.word(); !word.empty(); word = scanner.word())
        face.push_back(corner_index(word, mesh.vertices.size(), scanner));
      corners += face.size();
      mesh.face_part.push_back(parts.index(part_name, where));
      check_mesh_count(mesh.faces.size(), kMaxMeshFaces, "faces", where);
      check_mesh_count(corners, kMaxMeshCorners, "face corners", where);
    } else if (keyword == (has_objects ? "o" : "g")) {
      part_name = scanner.rest_of_line();
      if (part_name.empty()) part_name = "unnamed";
      if (has_objects) parts.index(part_name, where);
    } else if (keyword.find('\0') != std::string_view::npos) {
      scanner.fail("is not text; expected a Wavefront OBJ file");
    }
  }
  if (mesh.faces.empty()) throw InputError(where, "has no line \"f ...\"; expected a Wavefront OBJ file with faces");
  return mesh;
}

}  // namespace foreview
