#pragma once
#include <charconv>
#include <string>
#include <string_view>
#include <unordered_map>

#include "foreview/scene/polygon_model.h"

// The readers behind read_mesh(), one per format, from memory. All throw InputError at `where` (and line) on anything
// that is not a whole file of the format; counts that a file announces are never believed before its bytes are there.

namespace foreview {

[[nodiscard]] RawMesh parse_obj(std::string_view bytes, const std::string& where);
[[nodiscard]] RawMesh parse_off(std::string_view bytes, const std::string& where);
[[nodiscard]] RawMesh parse_ply(std::string_view bytes, const std::string& where);
[[nodiscard]] RawMesh parse_stl(std::string_view bytes, const std::string& where);
/// Any other format, by assimp, in a child process: whatever a damaged file does to assimp (crash, endless loop, all
/// of the memory), this process only sees an InputError. Files that the format refers to (glTF's .bin) are read too.
[[nodiscard]] RawMesh read_with_assimp(const std::filesystem::path& file);
/// By the extension of `name`: ".obj", ".off", ".ply" or ".stl", in any case; InputError for others.
[[nodiscard]] RawMesh parse_mesh(const std::string& name, std::string_view bytes);

/// Cuts a text into lines and words. Lines end with \n or \r\n.
class TextScanner {
 public:
  TextScanner(std::string_view text, std::string where) : rest_(text), where_(std::move(where)) {}

  /// Goes to the next line; false at the end.
  bool next_line();
  /// Goes to the next line that holds a word, comments (from '#') cut off.
  bool next_line_with_words();
  /// The line's next word, empty at its end.
  std::string_view word();
  /// What is left of the line, without blanks around it.
  std::string_view rest_of_line();
  /// The line's next word as a number; anything else is an InputError. "nan" and "inf" are numbers: cleaning counts
  /// them.
  double number(const char* what);
  template <typename Integer>
  Integer integer(const char* what) {
    const std::string_view text = word();
    Integer value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || text.empty()) fail_word(what, text);
    return value;
  }
  [[noreturn]] void fail(const std::string& why) const;
  [[nodiscard]] std::size_t line_number() const { return line_number_; }
  /// Bytes behind the current line.
  [[nodiscard]] std::string_view unread() const { return rest_; }

 private:
  [[noreturn]] void fail_word(const char* what, std::string_view text) const;
  std::string_view rest_, line_;
  std::string where_;
  std::size_t line_number_ = 0;
};

/// What a mesh may hold at most; see build_polygon_model().
inline constexpr std::size_t kMaxMeshFaces = 2'000'000;
inline constexpr std::size_t kMaxMeshCorners = 8'000'000;
inline constexpr std::size_t kMaxMeshParts = 10'000;
/// Throws InputError once a mesh being read has more of something than is supported.
void check_mesh_count(std::size_t count, std::size_t limit, const char* what, const std::string& where);

/// Numbers parts by name, in order of first mention.
class PartNames {
 public:
  explicit PartNames(std::vector<std::string>& names) : names_(names) {}
  std::uint32_t index(std::string_view name, const std::string& where);

 private:
  std::vector<std::string>& names_;
  std::unordered_map<std::string, std::uint32_t> known_;
};

}  // namespace foreview
