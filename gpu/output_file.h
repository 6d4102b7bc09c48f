#pragma once
#include <filesystem>
#include <initializer_list>
#include <string_view>

namespace foreview {

/// Writes the pieces one after the other. Throws InputError naming the file where the disk refuses.
void write_pieces(const std::filesystem::path& file, std::initializer_list<std::string_view> pieces);
/// Moves a file over another, at once. Throws InputError naming `to`.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace foreview
