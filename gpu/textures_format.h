#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "foreview/gpu/texture_store.h"

namespace foreview {

/// The text files of a directory of saved textures (save_textures()), without OpenGL or disk.
///
/// textures.yaml:
///   format: foreview-textures
///   version: 2
///   model_fingerprint: "16 hexadecimal digits"   # PolygonModel::fingerprint()
///   layout_fingerprint: "..."                    # layout_fingerprint()
///   polygons: 1936
///   charts: 1747                                 # groups of polygons that share a block
///   page_size: 4096
///   page_checksums: ["...", "..."]               # file_checksum() of page-000.png, page-001.png ...
///   states_checksum: "..."                       # of polygon-states.csv
/// polygon-states.csv: the line "red,green,blue,seen", then one line per polygon.
struct TexturesIndex {
  std::uint64_t model_fingerprint = 0, layout_fingerprint = 0;
  int polygons = 0;
  int charts = 0;
  int page_size = 0;
  std::vector<std::uint64_t> page_checksums;
  std::uint64_t states_checksum = 0;
  bool operator==(const TexturesIndex&) const = default;
};

inline constexpr int kTexturesVersion = 2;

[[nodiscard]] std::string to_textures_yaml(const TexturesIndex& index);
/// Throws InputError ("WHERE:LINE: ...") where a key is missing, unknown, of a wrong kind or out of range.
[[nodiscard]] TexturesIndex parse_textures_yaml(const std::string& text, const std::string& where);

[[nodiscard]] std::string to_states_csv(const std::vector<TextureStore::PolygonState>& states);
/// Colours must be within 0..1, seen 0, 0.5 or 1, and there must be `polygons` of them. Reads back bit by bit what
/// to_states_csv() wrote. Throws InputError ("WHERE:LINE: ...").
[[nodiscard]] std::vector<TextureStore::PolygonState> parse_states_csv(std::string_view text, const std::string& where,
                                                                       std::size_t polygons);

/// Where the charts lie and which polygons share one; textures fit only a layout with the same one.
[[nodiscard]] std::uint64_t layout_fingerprint(const ChartLayout& layout);
/// FNV-1a, 64 bits: against damage, not against intent.
[[nodiscard]] std::uint64_t file_checksum(std::string_view bytes);
/// Width and height of a PNG with 8-bit RGBA pixels, from its first bytes; false where it is something else.
[[nodiscard]] bool read_rgba_png_size(std::string_view bytes, std::uint32_t& width, std::uint32_t& height);

}  // namespace foreview
