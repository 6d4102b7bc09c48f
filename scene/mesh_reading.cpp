#include "foreview/scene/mesh_reading.h"

#include <algorithm>
#include <cctype>
#include <limits>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

constexpr std::size_t kMaxFileSize = std::size_t{1} << 30;

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string extension_of(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_own_format(const std::string& extension) {
  return extension == ".obj" || extension == ".off" || extension == ".ply" || extension == ".stl";
}

}  // namespace

bool TextScanner::next_line() {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++line_number_;
  return true;
}

bool TextScanner::next_line_with_words() {
  while (next_line()) {
    line_ = line_.substr(0, line_.find('#'));
    if (line_.find_first_not_of(kBlanks) != std::string_view::npos) return true;
  }
  return false;
}

std::string_view TextScanner::word() {
  const std::size_t begin = line_.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    line_ = {};
    return {};
  }
  line_.remove_prefix(begin);
  const std::string_view result = line_.substr(0, line_.find_first_of(kBlanks));
  line_.remove_prefix(result.size());
  return result;
}

std::string_view TextScanner::rest_of_line() {
  const std::size_t begin = line_.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return line_.substr(begin, line_.find_last_not_of(kBlanks) - begin + 1);
}

double TextScanner::number(const char* what) {
  const std::string_view text = word();
  const std::string_view digits = text.size() > 1 && text[0] == '+' ? text.substr(1) : text;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool complete = !digits.empty() && end == digits.data() + digits.size();
  // Too small or too large for a double: the former is as good as zero, the latter is counted as not finite.
  if (complete && error == std::errc::result_out_of_range)
    return digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos
               ? 0
               : std::numeric_limits<double>::infinity();
  if (!complete || error != std::errc()) fail_word(what, text);
  return value;
}

void TextScanner::fail(const std::string& why) const {
  throw InputError(where_ + ":" + std::to_string(line_number_), why);
}

void TextScanner::fail_word(const char* what, std::string_view text) const {
  if (text.empty()) fail(std::string("ends where ") + what + " was expected");
  fail(in_quotes(text) + " stands where " + what + " was expected");
}

void check_mesh_count(std::size_t count, std::size_t limit, const char* what, const std::string& where) {
  if (count > limit)
    throw InputError(where, "has more than " + std::to_string(limit) + " " + what +
                                ", the most that is supported; simplify the mesh");
}

std::uint32_t PartNames::index(std::string_view name, const std::string& where) {
  const auto [place, is_new] = known_.try_emplace(std::string(name), static_cast<std::uint32_t>(names_.size()));
  if (is_new) {
    names_.emplace_back(name);
    check_mesh_count(names_.size(), kMaxMeshParts, "parts", where);
  }
  return place->second;
}

RawMesh parse_mesh(const std::string& name, std::string_view bytes) {
  const std::string extension = extension_of(name);
  if (bytes.empty()) throw InputError(name, "is empty; expected a mesh");
  if (extension == ".obj") return parse_obj(bytes, name);
  if (extension == ".off") return parse_off(bytes, name);
  if (extension == ".ply") return parse_ply(bytes, name);
  if (extension == ".stl") return parse_stl(bytes, name);
  throw InputError(name, "is not of a format that is read from memory; expected .obj, .off, .ply or .stl");
}

RawMesh read_mesh(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string bytes = read_input_file(file, kMaxFileSize);
  if (bytes.empty()) throw InputError(name, "is empty; expected a mesh");
  return is_own_format(extension_of(name)) ? parse_mesh(name, bytes) : read_with_assimp(file);
}

}  // namespace foreview
