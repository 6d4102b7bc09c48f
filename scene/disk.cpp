#include "foreview/scene/disk.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

template <class Result>
Result checked(Result result) {
  return result < 0 ? static_cast<Result>(-errno) : result;
}

void sync_by_name(const std::filesystem::path& file, int flags, Disk& disk) {
  const int descriptor = disk.open(file, flags);
  int code = descriptor < 0 ? descriptor : disk.sync(descriptor);
  if (descriptor >= 0) {
    const int closed = disk.close(descriptor);
    if (code == 0) code = closed;
  }
  if (code < 0) throw InputError(file.string(), std::string("cannot be written: ") + std::strerror(-code));
}

}  // namespace

int Disk::open(const std::filesystem::path& file, int flags) {
  return checked(::open(file.c_str(), flags | O_CLOEXEC, 0666));
}
ssize_t Disk::write(int file, const void* data, std::size_t size) {
  ssize_t written = 0;
  do {
    written = checked(::write(file, data, size));
  } while (written == -EINTR);
  return written == 0 ? -ENOSPC : written;
}
std::int64_t Disk::size(int file) {
  struct stat status {};
  return ::fstat(file, &status) == 0 ? status.st_size : -errno;
}
int Disk::truncate(int file, std::int64_t size) {
  return checked(::ftruncate(file, size));
}
int Disk::sync(int file) {
  return checked(::fsync(file));
}
int Disk::close(int file) {
  return checked(::close(file));
}
int Disk::rename(const std::filesystem::path& from, const std::filesystem::path& to) {
  return checked(::rename(from.c_str(), to.c_str()));
}
int Disk::unlink(const std::filesystem::path& file) {
  return checked(::unlink(file.c_str()));
}
int Disk::make_directory(const std::filesystem::path& directory) {
  return checked(::mkdir(directory.c_str(), 0777));
}

Disk& real_disk() {
  static Disk disk;
  return disk;
}

void sync_file(const std::filesystem::path& file, Disk& disk) {
  sync_by_name(file, O_RDONLY, disk);
}
void sync_directory(const std::filesystem::path& directory, Disk& disk) {
  sync_by_name(directory.empty() ? "." : directory, O_RDONLY | O_DIRECTORY, disk);
}

}  // namespace foreview
