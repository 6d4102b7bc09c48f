#pragma once
#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <string>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// The system calls that capturing needs, and nothing else: tests put a simulated device and clock in their place.
/// Every member does what the call of its name does, but returns -errno where that returns -1 and sets errno.
class VideoSystem {
 public:
  VideoSystem() = default;
  virtual ~VideoSystem() = default;
  VideoSystem(const VideoSystem&) = delete;
  VideoSystem& operator=(const VideoSystem&) = delete;

  [[nodiscard]] virtual int open(const std::string& path, int flags) = 0;
  virtual int close(int file) = 0;
  [[nodiscard]] virtual int ioctl(int file, unsigned long request, void* argument) = 0;
  /// Shared, for reading and writing. Null where it fails, with `error` = -errno.
  [[nodiscard]] virtual void* mmap(std::size_t length, int file, std::int64_t offset, int& error) = 0;
  virtual int munmap(void* address, std::size_t length) = 0;
  /// With count 0 it sleeps.
  [[nodiscard]] virtual int poll(pollfd* files, std::size_t count, int timeout_ms) = 0;
  [[nodiscard]] virtual Timestamp now(clockid_t clock) = 0;
};

/// The operating system's own.
[[nodiscard]] VideoSystem& real_video_system();

}  // namespace foreview
