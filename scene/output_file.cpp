#include "foreview/scene/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

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

/// 0, or errno of the first write that failed.
int write_all(int descriptor, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written == 0 ? ENOSPC : errno;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

}  // namespace

void write_file_whole(const std::filesystem::path& file, std::span<const unsigned char> bytes) {
  write_file_whole(file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void write_file_whole(const std::filesystem::path& file, std::string_view text) {
  write_file_whole(file, {text});
}

void write_file_whole(const std::filesystem::path& file, std::initializer_list<std::string_view> pieces) {
  const std::filesystem::path beside = file.string() + ".part";
  const int descriptor = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) throw refused(file, errno);
  int code = 0;
  for (const std::string_view piece : pieces) {
    if (code == 0) code = write_all(descriptor, piece.data(), piece.size());
  }
  if (::close(descriptor) != 0 && code == 0) code = errno;
  if (code != 0) {
    ::unlink(beside.c_str());
    throw refused(file, code);
  }
  replace_file(beside, file);
}

void replace_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) == 0) return;
  const int code = errno;
  ::unlink(from.c_str());
  throw refused(to, code);
}

LineFile::LineFile(std::filesystem::path file, std::string header) : file_(std::move(file)), kept_(std::move(header)) {}

void LineFile::add(const std::string& line) {
  constexpr std::size_t kEnough = 64 * 1024;
  kept_ += line;
  kept_ += '\n';
  if (kept_.size() >= kEnough) flush();
}

void LineFile::flush() {
  if (kept_.empty()) return;
  const int descriptor = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) throw refused(file_, errno);
  struct stat before {};
  int code = ::fstat(descriptor, &before) == 0 ? 0 : errno;
  if (code == 0) code = write_all(descriptor, kept_.data(), kept_.size());
  // A line cut short by a full disk would read as another, wrong line.
  if (code != 0 && ::ftruncate(descriptor, before.st_size) != 0) code = errno;
  if (::close(descriptor) != 0 && code == 0) code = errno;
  if (code != 0) throw refused(file_, code);
  kept_.clear();
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
