#include <fstream>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {
namespace {

std::string object_name(const RawMesh& mesh, std::uint32_t part) {
  std::string name = part < mesh.part_names.size() ? mesh.part_names[part] : "model";
  for (char& c : name)
    if (static_cast<unsigned char>(c) < ' ' || c == '#' || c == '\\') c = '_';
  const std::size_t begin = name.find_first_not_of(' ');
  if (begin == std::string::npos) return "part-" + std::to_string(part);
  return name.substr(begin, name.find_last_not_of(' ') - begin + 1);
}

/// True if the parts, taken in the order in which faces first use them, are not all of them in their own order.
bool order_needs_telling(const RawMesh& mesh) {
  std::uint32_t expected = 0;
  for (const std::uint32_t part : mesh.face_part) {
    if (part > expected) return true;
    if (part == expected) ++expected;
  }
  return expected < mesh.part_names.size();
}

}  // namespace

void write_obj(const RawMesh& mesh, const std::filesystem::path& file) {
  std::string text = "# written by foreview; metres\n";
  for (const glm::dvec3& vertex : mesh.vertices) {
    text += 'v';
    for (int axis = 0; axis < 3; ++axis) {
      text += ' ';
      text += number_text(vertex[axis]);
    }
    text += '\n';
  }
  if (order_needs_telling(mesh))
    for (std::uint32_t part = 0; part < mesh.part_names.size(); ++part) text += "o " + object_name(mesh, part) + '\n';
  std::uint32_t current = ~0U;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::uint32_t part = f < mesh.face_part.size() ? mesh.face_part[f] : 0;
    if (part != current && !mesh.part_names.empty()) text += "o " + object_name(mesh, part) + '\n';
    current = part;
    text += 'f';
    for (const std::uint32_t corner : mesh.faces[f]) text += ' ' + std::to_string(std::uint64_t{corner} + 1);
    text += '\n';
  }
  const std::filesystem::path beside = file.string() + ".part";
  {
    std::ofstream stream(beside, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.flush();
    if (!stream) throw InputError(file.string(), "cannot be written; is the directory there, and the disk not full?");
  }
  std::error_code error;
  std::filesystem::rename(beside, file, error);
  if (error) throw InputError(file.string(), "cannot be written: " + error.message());
}

}  // namespace foreview
