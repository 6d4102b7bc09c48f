#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/mesh_reading.h"

namespace foreview {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY is read as it lies in memory");

enum class Number { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Encoding { text, little_endian, big_endian };

struct Property {
  std::string name;
  Number type = Number::float32;
  std::optional<Number> list_count;  // set for lists
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

std::optional<Number> number_type(std::string_view name) {
  if (name == "char" || name == "int8") return Number::int8;
  if (name == "uchar" || name == "uint8") return Number::uint8;
  if (name == "short" || name == "int16") return Number::int16;
  if (name == "ushort" || name == "uint16") return Number::uint16;
  if (name == "int" || name == "int32") return Number::int32;
  if (name == "uint" || name == "uint32") return Number::uint32;
  if (name == "float" || name == "float32") return Number::float32;
  if (name == "double" || name == "float64") return Number::float64;
  return std::nullopt;
}

std::size_t size_of(Number type) {
  switch (type) {
    case Number::int8:
    case Number::uint8:
      return 1;
    case Number::int16:
    case Number::uint16:
      return 2;
    case Number::float64:
      return 8;
    default:
      return 4;
  }
}

/// Numbers one after the other, from text or bytes; all types become double, which holds them exactly.
class NumberReader {
 public:
  NumberReader(TextScanner& scanner, Encoding encoding, const std::string& where)
      : scanner_(scanner), encoding_(encoding), bytes_(scanner.unread()), where_(where) {}

  /// Text: each element stands in a line of its own.
  void begin_element(const Element& element, std::uint64_t done) {
    element_ = &element;
    done_ = done;
    if (encoding_ == Encoding::text && !scanner_.next_line_with_words()) fail_end();
  }

  double next(Number type, const char* what) {
    if (encoding_ == Encoding::text) return scanner_.number(what);
    const std::size_t size = size_of(type);
    if (bytes_.size() < size) fail_end();
    std::array<char, 8> raw{};
    std::copy_n(bytes_.data(), size, raw.begin());
    bytes_.remove_prefix(size);
    if (encoding_ == Encoding::big_endian) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    switch (type) {
      case Number::int8:
        return as<std::int8_t>(raw);
      case Number::uint8:
        return as<std::uint8_t>(raw);
      case Number::int16:
        return as<std::int16_t>(raw);
      case Number::uint16:
        return as<std::uint16_t>(raw);
      case Number::int32:
        return as<std::int32_t>(raw);
      case Number::uint32:
        return as<std::uint32_t>(raw);
      case Number::float32:
        return static_cast<double>(as<float>(raw));
      case Number::float64:
        return as<double>(raw);
    }
    return 0;
  }

 private:
  template <typename T>
  static T as(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  [[noreturn]] void fail_end() const {
    throw InputError(where_, "is cut off: ends in " + element_->name + " " + std::to_string(done_) + " of " +
                                 std::to_string(element_->count));
  }
  TextScanner& scanner_;
  Encoding encoding_;
  std::string_view bytes_;
  std::string where_;
  const Element* element_ = nullptr;
  std::uint64_t done_ = 0;
};

struct Header {
  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
};

Property parse_property(TextScanner& scanner) {
  Property property;
  std::string_view type = scanner.word();
  if (type == "list") {
    property.list_count = number_type(scanner.word());
    if (!property.list_count || *property.list_count == Number::float32 || *property.list_count == Number::float64)
      scanner.fail("a list property's count must be of an integer type");
    type = scanner.word();
  }
  const std::optional<Number> known = number_type(type);
  if (!known) scanner.fail("unknown property type " + in_quotes(type));
  property.type = *known;
  property.name = scanner.word();
  return property;
}

Header parse_header(TextScanner& scanner) {
  Header header;
  if (!scanner.next_line() || scanner.rest_of_line() != "ply")
    scanner.fail("does not begin with \"ply\"; expected a PLY file");
  bool has_format = false;
  while (true) {
    if (!scanner.next_line()) scanner.fail("ends within its header; expected \"end_header\"");
    const std::string_view keyword = scanner.word();
    if (keyword == "end_header") break;
    if (keyword == "comment" || keyword == "obj_info" || keyword.empty()) continue;
    if (keyword == "format") {
      const std::string_view format = scanner.word();
      if (format == "ascii")
        header.encoding = Encoding::text;
      else if (format == "binary_little_endian")
        header.encoding = Encoding::little_endian;
      else if (format == "binary_big_endian")
        header.encoding = Encoding::big_endian;
      else
        scanner.fail("unknown format; expected ascii, binary_little_endian or binary_big_endian");
      has_format = true;
    } else if (keyword == "element") {
      Element& element = header.elements.emplace_back();
      element.name = scanner.word();
      element.count = scanner.integer<std::uint64_t>("the element's count");
      if (header.elements.size() > 64) scanner.fail("announces more than 64 elements");
    } else if (keyword == "property") {
      if (header.elements.empty()) scanner.fail("a property stands before any element");
      header.elements.back().properties.push_back(parse_property(scanner));
      if (header.elements.back().properties.size() > 1024) scanner.fail("an element has more than 1024 properties");
    } else {
      scanner.fail("unknown header line; expected format, comment, element, property or end_header");
    }
  }
  if (!has_format) scanner.fail("the header has no line \"format ...\"");
  return header;
}

std::uint32_t to_index(double number) {
  // Cleaning drops and counts faces with an index out of range.
  return number >= 0 && number < 4294967295.0 && number == std::floor(number) ? static_cast<std::uint32_t>(number)
                                                                              : ~0U;
}

class PlyParser {
 public:
  PlyParser(std::string_view bytes, std::string where) : where_(std::move(where)), scanner_(bytes, where_) {}

  RawMesh run() {
    const Header header = parse_header(scanner_);
    NumberReader reader(scanner_, header.encoding, where_);
    for (const Element& element : header.elements) read_element(element, reader);
    if (mesh_.vertices.empty()) throw InputError(where_, "has no vertices with x, y and z");
    if (mesh_.faces.empty()) throw InputError(where_, "has no faces (a list property vertex_indices of element face)");
    return std::move(mesh_);
  }

 private:
  void read_element(const Element& element, NumberReader& reader) {
    const bool is_vertex = element.name == "vertex";
    const bool is_face = element.name == "face";
    if (is_vertex) check_mesh_count(element.count, kMaxMeshCorners, "vertices", where_);
    if (is_face) check_mesh_count(element.count, kMaxMeshFaces, "faces", where_);
    // Without properties, a count alone would keep us busy for as long as it says.
    if (element.properties.empty()) {
      if (element.count > 0) throw InputError(where_, "element " + element.name + " has no properties");
      return;
    }
    if (is_vertex) require_coordinates(element);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      reader.begin_element(element, i);
      glm::dvec3 point(0);
      for (const Property& property : element.properties) {
        if (property.list_count) {
          read_list(property, is_face && is_corner_list(property), reader);
        } else {
          const double value = reader.next(property.type, property.name.c_str());
          if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
            point[property.name[0] - 'x'] = value;
        }
      }
      if (is_vertex) mesh_.vertices.push_back(point);
    }
  }

  static bool is_corner_list(const Property& property) {
    return property.name == "vertex_indices" || property.name == "vertex_index";
  }

  void require_coordinates(const Element& element) const {
    for (const char* axis : {"x", "y", "z"}) {
      if (std::none_of(element.properties.begin(), element.properties.end(),
                       [&](const Property& p) { return p.name == axis && !p.list_count; }))
        throw InputError(where_, std::string("its vertices have no property ") + axis);
    }
  }

  void read_list(const Property& property, bool is_face, NumberReader& reader) {
    const double count = reader.next(*property.list_count, "a list's length");
    if (!(count >= 0 && count <= static_cast<double>(kMaxMeshCorners) && count == std::floor(count)))
      throw InputError(where_, "a list " + property.name + " has an impossible length");
    std::vector<std::uint32_t> face;
    for (auto left = static_cast<std::uint64_t>(count); left > 0; --left) {
      const double value = reader.next(property.type, "a list's item");
      if (is_face) face.push_back(to_index(value));
    }
    if (!is_face) return;
    corners_ += face.size();
    check_mesh_count(corners_, kMaxMeshCorners, "face corners", where_);
    mesh_.faces.push_back(std::move(face));
  }

  std::string where_;
  TextScanner scanner_;
  RawMesh mesh_;
  std::size_t corners_ = 0;
};

}  // namespace

RawMesh parse_ply(std::string_view bytes, const std::string& where) {
  return PlyParser(bytes, where).run();
}

}  // namespace foreview
