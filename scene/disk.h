#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace foreview {

/// The system calls with which files are written, so that tests can fill the disk and cut the power. A failure is
/// returned as -errno. Thread-safe as the calls are.
class Disk {
 public:
  Disk() = default;
  virtual ~Disk() = default;
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;

  /// `flags` of open(2), O_CLOEXEC and mode 0666 understood; a directory opened for reading can be synced.
  virtual int open(const std::filesystem::path& file, int flags);
  /// Bytes written, at least one, or -errno.
  virtual ssize_t write(int file, const void* data, std::size_t size);
  virtual std::int64_t size(int file);
  virtual int truncate(int file, std::int64_t size);
  /// Returns once the file's content is where no power cut takes it; of a directory, the names in it.
  virtual int sync(int file);
  virtual int close(int file);
  virtual int rename(const std::filesystem::path& from, const std::filesystem::path& to);
  virtual int unlink(const std::filesystem::path& file);
  virtual int make_directory(const std::filesystem::path& directory);
};

/// The machine's.
[[nodiscard]] Disk& real_disk();

/// Disk::sync of a file or directory by its name. Throws InputError naming it.
void sync_file(const std::filesystem::path& file, Disk& disk);
void sync_directory(const std::filesystem::path& directory, Disk& disk);

}  // namespace foreview
