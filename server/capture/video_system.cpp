#include "foreview/server/capture/video_system.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace foreview {
namespace {

int or_error(int result) {
  return result < 0 ? -errno : result;
}

class RealVideoSystem : public VideoSystem {
 public:
  int open(const std::string& path, int flags) override { return or_error(::open(path.c_str(), flags)); }
  int close(int file) override { return or_error(::close(file)); }
  int ioctl(int file, unsigned long request, void* argument) override {
    return or_error(::ioctl(file, request, argument));
  }
  void* mmap(std::size_t length, int file, std::int64_t offset, int& error) override {
    void* const address = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, file, offset);
    if (address != MAP_FAILED) return address;
    error = -errno;
    return nullptr;
  }
  int munmap(void* address, std::size_t length) override { return or_error(::munmap(address, length)); }
  int poll(pollfd* files, std::size_t count, int timeout_ms) override {
    return or_error(::poll(files, count, timeout_ms));
  }
  Timestamp now(clockid_t clock) override {
    timespec time{};
    clock_gettime(clock, &time);
    return {std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec};
  }
};

}  // namespace

VideoSystem& real_video_system() {
  static RealVideoSystem system;
  return system;
}

}  // namespace foreview
