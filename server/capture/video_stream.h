#pragma once
#include <linux/videodev2.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/server/capture/captured_bytes.h"
#include "foreview/server/capture/video_system.h"

namespace foreview {

/// A camera cannot be opened or does not do as agreed. `code`: the errno behind it; 0: none, it will not pass by
/// itself.
class VideoError : public InputError {
 public:
  VideoError(const std::string& where, const std::string& why, int code) : InputError(where, why), code_(code) {}
  [[nodiscard]] int code() const { return code_; }

 private:
  int code_;
};

/// A V4L2 camera that streams into mapped memory, from its opening to its unplugging; what to do about faults is
/// decided by V4l2Camera. Single-planar capture devices with streaming, as UVC cameras are.
class VideoStream {
 public:
  /// Opens `device`, agrees on a format and begins to stream into `buffers` buffers (2 to 32; drivers may give more, or
  /// fewer). Throws VideoError or InputError, with everything undone.
  VideoStream(VideoSystem& system, std::string device, const CaptureWish& wish, std::size_t buffers);
  ~VideoStream();
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  /// size_image is the most that arrives; the mode's rate is what the driver says it will be (0: it does not).
  [[nodiscard]] const VideoFormat& format() const { return format_; }
  /// The camera's own name.
  [[nodiscard]] const std::string& name() const { return name_; }

  struct Readiness {
    bool is_ready = false;         ///< dequeue() may have something, or tell what is wrong
    bool is_faulty = false;        ///< POLLERR, POLLHUP or POLLNVAL
    bool was_interrupted = false;  ///< a signal came
  };
  /// Waits for a picture; at most `timeout`.
  [[nodiscard]] Readiness wait(Duration timeout);
  /// Takes a filled buffer out: 0, or -EAGAIN where there is none, or what else the driver says.
  [[nodiscard]] int dequeue(v4l2_buffer& buffer);
  /// What the driver wrote into it; no more than there is memory, whatever it says.
  [[nodiscard]] std::span<const unsigned char> bytes_of(const v4l2_buffer& buffer) const;
  /// Gives the buffer back to be filled again.
  [[nodiscard]] int requeue(const v4l2_buffer& buffer);
  /// Queues buffers that neither side holds: a failed dequeue may leave such. How many.
  std::size_t requeue_strays();
  /// Buffers that the driver has, as far as this side knows.
  [[nodiscard]] std::size_t queued() const { return queued_; }

 private:
  void open_device();
  void agree(const CaptureWish& wish);
  void set_rate(const CaptureMode& chosen);
  void map_buffers(std::size_t buffers);
  void begin_streaming();
  void end();
  [[noreturn]] void fail(const std::string& action, int error) const;

  struct Memory {
    void* address = nullptr;
    std::size_t length = 0;
  };
  VideoSystem& system_;
  const std::string device_;
  std::string name_;
  int file_ = -1;
  VideoFormat format_;
  std::vector<Memory> memory_;
  bool has_buffers_ = false, is_streaming_ = false;
  std::size_t queued_ = 0;
};

/// What opening a camera would find, for lists: every /dev/video0..63 that captures, with its name and modes.
struct VideoDevice {
  std::string path, name;
  std::vector<CaptureMode> modes;
};
[[nodiscard]] std::vector<VideoDevice> list_video_devices(VideoSystem& system);

}  // namespace foreview
