#pragma once
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "foreview/scene/disk.h"

namespace foreview {

/// Writes a file so that at any moment the old one or the whole new one is there: beside it, then renamed. Throws
/// InputError naming the file where the disk refuses; then nothing new is left behind.
void write_file_whole(const std::filesystem::path& file, std::span<const unsigned char> bytes,
                      Disk& disk = real_disk());
void write_file_whole(const std::filesystem::path& file, std::string_view text, Disk& disk = real_disk());
/// The pieces one after the other, for files too large to copy together.
void write_file_whole(const std::filesystem::path& file, std::initializer_list<std::string_view> pieces,
                      Disk& disk = real_disk());
/// Moves a whole file over another, at once; where that is refused `from` is removed. Throws InputError naming `to`.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to, Disk& disk = real_disk());

/// Throws InputError naming the option that asks for the file where its directory is not there, or it is a directory
/// itself: found out at the end, that would cost the whole run. An empty name is no file.
void check_output_file(const std::filesystem::path& file, const char* option);

/// A text file to which only whole lines are ever appended.
class LineFile {
 public:
  /// Creates the file at the first flush, holding `header` first.
  LineFile(std::filesystem::path file, std::string header, Disk& disk = real_disk());
  /// Keeps a line (without its end); writes what is kept when much has come together.
  void add(const std::string& line);
  /// Appends the kept lines. Throws InputError naming the file where the disk refuses; then no part of them is there.
  void flush();
  /// Flushes, and returns once no power cut takes what was appended. Throws InputError likewise.
  void sync();

 private:
  std::filesystem::path file_;
  std::string kept_;
  Disk* disk_;
  bool is_new_ = true;      ///< its name is not known to be in the directory for good
  bool is_synced_ = false;  ///< nothing was appended since the last sync
};

}  // namespace foreview
