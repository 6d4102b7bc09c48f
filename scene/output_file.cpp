#include "foreview/scene/output_file.h"

#include <fcntl.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

InputError refused(const std::filesystem::path& file, int code) {
  return {file.string(), std::string("cannot be written: ") + std::strerror(code)};
}

/// 0, or -errno of the first write that failed.
int write_all(Disk& disk, int descriptor, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = disk.write(descriptor, data, size);
    if (written < 0) return static_cast<int>(written);
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

}  // namespace

void write_file_whole(const std::filesystem::path& file, std::span<const unsigned char> bytes, Disk& disk) {
  write_file_whole(file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()), disk);
}

void write_file_whole(const std::filesystem::path& file, std::string_view text, Disk& disk) {
  write_file_whole(file, {text}, disk);
}

void write_file_whole(const std::filesystem::path& file, std::initializer_list<std::string_view> pieces, Disk& disk) {
  const std::filesystem::path beside = file.string() + ".part";
  const int descriptor = disk.open(beside, O_WRONLY | O_CREAT | O_TRUNC);
  if (descriptor < 0) throw refused(file, -descriptor);
  int code = 0;
  for (const std::string_view piece : pieces) {
    if (code == 0) code = write_all(disk, descriptor, piece.data(), piece.size());
  }
  const int closed = disk.close(descriptor);
  if (code == 0) code = closed;
  if (code != 0) {
    disk.unlink(beside);
    throw refused(file, -code);
  }
  replace_file(beside, file, disk);
}

void replace_file(const std::filesystem::path& from, const std::filesystem::path& to, Disk& disk) {
  const int code = disk.rename(from, to);
  if (code == 0) return;
  disk.unlink(from);
  throw refused(to, -code);
}

LineFile::LineFile(std::filesystem::path file, std::string header, Disk& disk)
    : file_(std::move(file)), kept_(std::move(header)), disk_(&disk) {}

void LineFile::add(const std::string& line) {
  constexpr std::size_t kEnough = 64 * 1024;
  kept_ += line;
  kept_ += '\n';
  if (kept_.size() >= kEnough) flush();
}

void LineFile::flush() {
  if (kept_.empty()) return;
  const int descriptor = disk_->open(file_, O_WRONLY | O_CREAT | O_APPEND);
  if (descriptor < 0) throw refused(file_, -descriptor);
  const std::int64_t before = disk_->size(descriptor);
  int code = before < 0 ? static_cast<int>(before) : write_all(*disk_, descriptor, kept_.data(), kept_.size());
  // A line cut short by a full disk would read as another, wrong line.
  if (code != 0 && before >= 0) {
    if (const int cut = disk_->truncate(descriptor, before); cut != 0) code = cut;
  }
  const int closed = disk_->close(descriptor);
  if (code == 0) code = closed;
  if (code != 0) throw refused(file_, -code);
  kept_.clear();
  is_synced_ = false;
}

void LineFile::sync() {
  flush();
  if (is_synced_) return;
  sync_file(file_, *disk_);
  if (is_new_) sync_directory(file_.parent_path(), *disk_);
  is_new_ = false;
  is_synced_ = true;
}

void check_output_file(const std::filesystem::path& file, const char* option) {
  if (file.empty()) return;
  const std::filesystem::path folder = file.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder)) {
    throw InputError(option, "no such directory: " + folder.string());
  }
  if (std::filesystem::is_directory(file)) throw InputError(option, file.string() + " is a directory, expected a file");
}

}  // namespace foreview
