#include "foreview/gpu/textures_format.h"

#include <array>
#include <charconv>
#include <limits>
#include <optional>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/yaml_input.h"

namespace foreview {
namespace {

constexpr const char* kFormat = "foreview-textures";
constexpr std::string_view kStatesHeader = "red,green,blue,seen";

std::string hex(std::uint64_t value) {
  static constexpr const char* kDigits = "0123456789abcdef";
  std::string text(16, '0');
  for (auto digit = text.rbegin(); digit != text.rend(); ++digit, value >>= 4) *digit = kDigits[value & 15];
  return text;
}

std::uint64_t parse_hex(const YamlMap& map, const std::string& key, const std::string& text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value, 16);
  if (text.size() != 16 || error != std::errc() || stop != end) {
    map.fail(key, in_quotes(text) + " is not a number of 16 hexadecimal digits");
  }
  return value;
}

template <typename Value>
Value required(const YamlMap& map, const std::string& key, std::optional<Value> value) {
  if (!value) map.fail(key, "is missing");
  return *std::move(value);
}

class Fnv1a {
 public:
  void add(unsigned char byte) { hash_ = (hash_ ^ byte) * 0x100000001b3ULL; }
  void add(std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) add(static_cast<unsigned char>(value >> shift));
  }
  [[nodiscard]] std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

void append_number(std::string& text, float value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), result.ptr);
}

/// The numbers of one line, or an explanation.
std::optional<TextureStore::PolygonState> parse_state(std::string_view line) {
  std::array<float, 4> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == numbers.size())) return std::nullopt;
    const std::string_view field = line.substr(0, comma);
    const char* const end = field.data() + field.size();
    const auto [stop, error] = std::from_chars(field.data(), end, numbers[i]);
    if (error != std::errc() || stop != end || !(numbers[i] >= 0.0F && numbers[i] <= 1.0F)) return std::nullopt;
    line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  }
  if (numbers[3] != 0.0F && numbers[3] != 0.5F && numbers[3] != 1.0F) return std::nullopt;
  return TextureStore::PolygonState{numbers[0], numbers[1], numbers[2], numbers[3]};
}

}  // namespace

std::string to_textures_yaml(const TexturesIndex& index) {
  std::string text = std::string("format: ") + kFormat + "\nversion: " + std::to_string(kTexturesVersion) + "\n";
  text += "model_fingerprint: \"" + hex(index.model_fingerprint) + "\"\n";
  text += "layout_fingerprint: \"" + hex(index.layout_fingerprint) + "\"\n";
  text += "polygons: " + std::to_string(index.polygons) + "\n";
  text += "charts: " + std::to_string(index.charts) + "\n";
  text += "page_size: " + std::to_string(index.page_size) + "\n";
  text += "page_checksums: [";
  for (std::size_t i = 0; i < index.page_checksums.size(); ++i) {
    text += (i == 0 ? "\"" : ", \"") + hex(index.page_checksums[i]) + "\"";
  }
  text += "]\nstates_checksum: \"" + hex(index.states_checksum) + "\"\n";
  return text;
}

TexturesIndex parse_textures_yaml(const std::string& text, const std::string& where) {
  const YamlMap map = YamlMap::parse(text, where);
  const std::string format = required(map, "format", map.text("format"));
  if (format != kFormat) map.fail("format", in_quotes(format) + " is not " + kFormat);
  const int version = required(map, "version", map.integer("version", 0, std::numeric_limits<int>::max()));
  if (version != kTexturesVersion) {
    map.fail("version", "is " + std::to_string(version) + "; this program reads " + std::to_string(kTexturesVersion));
  }
  map.allow_only({"format", "version", "model_fingerprint", "layout_fingerprint", "polygons", "charts", "page_size",
                  "page_checksums", "states_checksum"});
  const auto hash = [&](const std::string& key) { return parse_hex(map, key, required(map, key, map.text(key))); };
  TexturesIndex index;
  index.model_fingerprint = hash("model_fingerprint");
  index.layout_fingerprint = hash("layout_fingerprint");
  index.polygons = required(map, "polygons", map.integer("polygons", 1, std::numeric_limits<int>::max()));
  index.charts = required(map, "charts", map.integer("charts", 1, std::numeric_limits<int>::max()));
  index.page_size = required(map, "page_size", map.integer("page_size", 1, 1 << 20));
  for (const std::string& checksum : required(map, "page_checksums", map.texts("page_checksums"))) {
    index.page_checksums.push_back(parse_hex(map, "page_checksums", checksum));
  }
  index.states_checksum = hash("states_checksum");
  return index;
}

std::string to_states_csv(const std::vector<TextureStore::PolygonState>& states) {
  std::string text(kStatesHeader);
  text += '\n';
  for (const TextureStore::PolygonState& state : states) {
    for (const float number : {state.red, state.green, state.blue}) {
      append_number(text, number);
      text += ',';
    }
    append_number(text, state.seen);
    text += '\n';
  }
  return text;
}

std::vector<TextureStore::PolygonState> parse_states_csv(std::string_view text, const std::string& where,
                                                         std::size_t polygons) {
  std::vector<TextureStore::PolygonState> states;
  for (std::size_t line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) {
      throw InputError(where + ":" + std::to_string(line_number), "the file is cut off: its last line has no end");
    }
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (line_number == 1) {
      if (line == kStatesHeader) continue;
      throw InputError(where + ":1", in_quotes(line) + " is not the header " + std::string(kStatesHeader));
    }
    const std::optional<TextureStore::PolygonState> state = parse_state(line);
    if (!state) {
      throw InputError(where + ":" + std::to_string(line_number),
                       in_quotes(line) + " is not RED,GREEN,BLUE,SEEN with colours from 0 to 1 and SEEN 0, 0.5 or 1");
    }
    if (states.size() == polygons) {
      throw InputError(where + ":" + std::to_string(line_number),
                       "more lines than the model's " + std::to_string(polygons) + " polygons");
    }
    states.push_back(*state);
  }
  if (states.size() != polygons) {
    throw InputError(where, "has the states of " + std::to_string(states.size()) + " polygons; expected " +
                                std::to_string(polygons));
  }
  return states;
}

std::uint64_t layout_fingerprint(const ChartLayout& layout) {
  Fnv1a hash;
  hash.add(static_cast<std::uint32_t>(layout.page_size));
  hash.add(layout.pages);
  for (const ChartGroup& group : layout.groups) {
    hash.add(group.page);
    for (const glm::ivec2& v : {group.origin, group.size, group.inner}) {
      hash.add(static_cast<std::uint32_t>(v.x));
      hash.add(static_cast<std::uint32_t>(v.y));
    }
    hash.add(group.member_count);
  }
  for (const std::uint32_t polygon : layout.members) hash.add(polygon);
  return hash.hash();
}

std::uint64_t file_checksum(std::string_view bytes) {
  Fnv1a hash;
  for (const char byte : bytes) hash.add(static_cast<unsigned char>(byte));
  return hash.hash();
}

bool read_rgba_png_size(std::string_view bytes, std::uint32_t& width, std::uint32_t& height) {
  static constexpr std::string_view kStart("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR", 16);
  if (bytes.size() < 33 || bytes.substr(0, kStart.size()) != kStart) return false;
  const auto big_endian = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  width = big_endian(16);
  height = big_endian(20);
  return bytes[24] == 8 && bytes[25] == 6;
}

}  // namespace foreview
