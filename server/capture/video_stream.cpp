#include "foreview/server/capture/video_stream.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "foreview/server/capture/video_modes.h"

namespace foreview {
namespace {

constexpr std::size_t kFewestBuffers = 2, kMostBuffers = 32;
/// More than any camera has; what is beyond is a driver's mistake.
constexpr std::uint32_t kMostExtent = 32768;
constexpr std::size_t kMostImageBytes = std::size_t{1} << 30;

/// From a fixed field that need not be terminated, and may hold anything.
template <std::size_t kSize>
std::string text_of(const unsigned char (&field)[kSize]) {
  std::string text(reinterpret_cast<const char*>(field), strnlen(reinterpret_cast<const char*>(field), kSize));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::uint32_t capabilities_of(const v4l2_capability& answer) {
  return (answer.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? answer.device_caps : answer.capabilities;
}

constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;

}  // namespace

VideoStream::VideoStream(VideoSystem& system, std::string device, const CaptureWish& wish, std::size_t buffers)
    : system_(system), device_(std::move(device)) {
  try {
    open_device();
    agree(wish);
    map_buffers(std::clamp(buffers, kFewestBuffers, kMostBuffers));
    begin_streaming();
  } catch (...) {
    end();
    throw;
  }
}

VideoStream::~VideoStream() {
  end();
}

void VideoStream::fail(const std::string& action, int error) const {
  const int code = -error;
  std::string why = action + ": " + std::generic_category().message(code);
  if (code == EBUSY) why = "is in use by another program; expected a free camera";
  if (code == ENODEV || code == ENXIO) why = "is gone: unplugged, or reset; expected a camera that stays";
  if (code == ENOMEM) why = action + ": no memory for its buffers; expected room for " + format_.mode.to_string();
  throw VideoError(device_, why, code);
}

void VideoStream::open_device() {
  file_ = system_.open(device_, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) {
    const int error = std::exchange(file_, -1);
    if (error == -ENOENT) throw VideoError(device_, "does not exist; expected a camera such as /dev/video0", ENOENT);
    if (error == -EACCES) {
      throw VideoError(device_, "may not be opened; expected a user of the group 'video'", EACCES);
    }
    fail("cannot be opened", error);
  }
  v4l2_capability answer{};
  if (const int error = video_ioctl(system_, file_, VIDIOC_QUERYCAP, answer); error < 0) {
    if (error == -ENODEV) fail("cannot be asked", error);
    throw VideoError(device_, "is no video device; expected one such as /dev/video0", 0);
  }
  name_ = text_of(answer.card);
  const std::uint32_t capabilities = capabilities_of(answer);
  if ((capabilities & kNeeded) == kNeeded) return;
  std::string why = "gives no pictures by streaming";
  if ((capabilities & V4L2_CAP_META_CAPTURE) != 0) why = "gives a camera's metadata, not its pictures (try the next)";
  if ((capabilities & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0) why = "is a multi-planar device, which is not supported";
  throw VideoError(device_, why + "; expected a camera that streams", 0);
}

void VideoStream::agree(const CaptureWish& wish) {
  const CaptureMode chosen = choose_mode(list_modes(system_, file_, wish), wish, device_);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = video_ioctl(system_, file_, VIDIOC_G_FMT, format); error < 0) fail("has no format", error);
  v4l2_pix_format& pixels = format.fmt.pix;
  if (wish.width > 0 || chosen.width > 0) {
    pixels.width = static_cast<std::uint32_t>(chosen.width > 0 ? chosen.width : wish.width);
    pixels.height = static_cast<std::uint32_t>(chosen.height > 0 ? chosen.height : wish.height);
  }
  const std::uint32_t width = pixels.width, height = pixels.height;
  pixels.pixelformat = chosen.fourcc;
  pixels.field = V4L2_FIELD_NONE;
  pixels.bytesperline = pixels.sizeimage = 0;
  if (const int error = video_ioctl(system_, file_, VIDIOC_S_FMT, format); error < 0) {
    fail("cannot be set to " + chosen.to_string(), error);
  }
  if (pixels.pixelformat != chosen.fourcc || pixels.width != width || pixels.height != height) {
    CaptureMode got = chosen;
    got.width = static_cast<int>(std::min(pixels.width, kMostExtent));
    got.height = static_cast<int>(std::min(pixels.height, kMostExtent));
    const bool same_format = pixels.pixelformat == chosen.fourcc;
    throw VideoError(device_,
                     (same_format ? "gives " + got.to_string() : std::string("gives another format")) +
                         " when asked for " + std::to_string(width) + "x" + std::to_string(height) + "; expected " +
                         name_of(chosen.format) + " of that size",
                     0);
  }
  if (pixels.field != V4L2_FIELD_NONE && pixels.field != V4L2_FIELD_ANY && pixels.field != V4L2_FIELD_INTERLACED &&
      pixels.field != V4L2_FIELD_INTERLACED_TB && pixels.field != V4L2_FIELD_INTERLACED_BT) {
    throw VideoError(device_, "gives half pictures (fields); expected whole ones", 0);
  }
  const std::size_t row = std::size_t{width} * bytes_per_pixel(chosen.format);
  format_.mode = chosen;
  format_.mode.width = static_cast<int>(width);
  format_.mode.height = static_cast<int>(height);
  format_.bytes_per_line = std::max<std::size_t>(pixels.bytesperline, row);
  format_.size_image = std::max<std::size_t>(pixels.sizeimage, format_.bytes_per_line * height);
  const bool is_possible =
      width > 0 && height > 0 && width <= kMostExtent && height <= kMostExtent &&
      (row == 0 || pixels.bytesperline == 0 || pixels.bytesperline >= row) && format_.size_image <= kMostImageBytes &&
      (chosen.format == CaptureFormat::grey || chosen.format == CaptureFormat::mjpeg || width % 2 == 0);
  if (!is_possible) {
    throw VideoError(device_,
                     "says impossible things of its pictures (" + std::to_string(width) + "x" + std::to_string(height) +
                         ", " + std::to_string(pixels.bytesperline) + " bytes a line, " +
                         std::to_string(pixels.sizeimage) + " in all); expected " + chosen.to_string(),
                     0);
  }
  set_rate(chosen);
}

void VideoStream::set_rate(const CaptureMode& chosen) {
  // Not every driver knows rates: then it has its own.
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_captureparm& capture = rate.parm.capture;
  const bool has_rate = video_ioctl(system_, file_, VIDIOC_G_PARM, rate) == 0;
  if (has_rate && chosen.rate() > 0 && (capture.capability & V4L2_CAP_TIMEPERFRAME) != 0) {
    capture.timeperframe = {chosen.interval_numerator, chosen.interval_denominator};
    if (const int error = video_ioctl(system_, file_, VIDIOC_S_PARM, rate); error == -EBUSY || error == -ENODEV) {
      fail("cannot be set to " + chosen.to_string(), error);
    }
  }
  if (has_rate) {
    format_.mode.interval_numerator = capture.timeperframe.numerator;
    format_.mode.interval_denominator = capture.timeperframe.denominator;
  }
}

void VideoStream::map_buffers(std::size_t buffers) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(buffers);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = video_ioctl(system_, file_, VIDIOC_REQBUFS, request); error < 0) {
    fail("gives no buffers", error);
  }
  has_buffers_ = true;
  if (request.count < kFewestBuffers) {
    throw VideoError(device_,
                     "gives " + std::to_string(request.count) + " of " + std::to_string(buffers) +
                         " buffers; expected 2 or more, one to fill while the other is read",
                     ENOMEM);
  }
  for (std::uint32_t index = 0; index < std::min<std::uint32_t>(request.count, kMostBuffers); ++index) {
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (const int error = video_ioctl(system_, file_, VIDIOC_QUERYBUF, buffer); error < 0) {
      fail("does not tell where its buffers are", error);
    }
    if (buffer.length == 0 || buffer.length < least_bytes(format_)) {
      throw VideoError(
          device_,
          "has buffers of " + std::to_string(buffer.length) + " bytes; expected room for " + format_.mode.to_string(),
          0);
    }
    int error = 0;
    void* const address = system_.mmap(buffer.length, file_, buffer.m.offset, error);
    if (address == nullptr) fail("does not share its buffers", error);
    memory_.push_back({address, buffer.length});
  }
}

void VideoStream::begin_streaming() {
  for (std::uint32_t index = 0; index < memory_.size(); ++index) {
    v4l2_buffer buffer{};
    buffer.index = index;
    if (const int error = requeue(buffer); error < 0) fail("does not take its buffers", error);
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = video_ioctl(system_, file_, VIDIOC_STREAMON, type); error < 0) {
    if (error == -ENOSPC) {
      throw VideoError(device_,
                       "does not fit on its USB bus beside others; expected room for " + format_.mode.to_string() +
                           " (a smaller size or rate, or another port)",
                       ENOSPC);
    }
    fail("does not begin to stream", error);
  }
  is_streaming_ = true;
}

void VideoStream::end() {
  if (file_ < 0) return;
  // Whatever these answer, closing comes next; a camera that is gone refuses them all.
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (is_streaming_) static_cast<void>(video_ioctl(system_, file_, VIDIOC_STREAMOFF, type));
  for (const Memory& memory : memory_) system_.munmap(memory.address, memory.length);
  memory_.clear();
  if (has_buffers_) {
    v4l2_requestbuffers none{};
    none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    none.memory = V4L2_MEMORY_MMAP;
    static_cast<void>(video_ioctl(system_, file_, VIDIOC_REQBUFS, none));
  }
  system_.close(std::exchange(file_, -1));
}

VideoStream::Readiness VideoStream::wait(Duration timeout) {
  pollfd file{.fd = file_, .events = POLLIN, .revents = 0};
  // Rounded up: rounded down, the last part of a millisecond would be spent spinning.
  const std::int64_t whole_ms = (std::max<std::int64_t>(timeout.nanoseconds, 0) + 999'999) / 1'000'000;
  const int result = system_.poll(&file, 1, static_cast<int>(std::min<std::int64_t>(whole_ms, 3'600'000)));
  if (result < 0) return {.is_faulty = result != -EINTR, .was_interrupted = result == -EINTR};
  return {.is_ready = (file.revents & POLLIN) != 0, .is_faulty = (file.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0};
}

int VideoStream::dequeue(v4l2_buffer& buffer) {
  buffer = {};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  const int error = video_ioctl(system_, file_, VIDIOC_DQBUF, buffer);
  if (error < 0) return error;
  if (buffer.index >= memory_.size()) return -EIO;
  if (queued_ > 0) --queued_;
  return 0;
}

std::span<const unsigned char> VideoStream::bytes_of(const v4l2_buffer& buffer) const {
  const Memory& memory = memory_[buffer.index];
  return {static_cast<const unsigned char*>(memory.address), std::min<std::size_t>(buffer.bytesused, memory.length)};
}

int VideoStream::requeue(const v4l2_buffer& buffer) {
  v4l2_buffer given{};
  given.index = buffer.index;
  given.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  given.memory = V4L2_MEMORY_MMAP;
  const int error = video_ioctl(system_, file_, VIDIOC_QBUF, given);
  if (error < 0) return error;
  ++queued_;
  return 0;
}

std::size_t VideoStream::requeue_strays() {
  std::size_t strays = 0, queued = 0;
  for (std::uint32_t index = 0; index < memory_.size(); ++index) {
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (video_ioctl(system_, file_, VIDIOC_QUERYBUF, buffer) < 0) return strays;
    if ((buffer.flags & (V4L2_BUF_FLAG_QUEUED | V4L2_BUF_FLAG_DONE)) != 0) {
      ++queued;
    } else if (requeue(buffer) == 0) {
      ++strays;
    }
  }
  queued_ = queued + strays;
  return strays;
}

std::vector<VideoDevice> list_video_devices(VideoSystem& system) {
  std::vector<VideoDevice> devices;
  constexpr int kMostDevices = 64;
  for (int number = 0; number < kMostDevices; ++number) {
    const std::string path = "/dev/video" + std::to_string(number);
    const int file = system.open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) continue;
    v4l2_capability answer{};
    if (video_ioctl(system, file, VIDIOC_QUERYCAP, answer) == 0 && (capabilities_of(answer) & kNeeded) == kNeeded) {
      devices.push_back({path, text_of(answer.card), list_modes(system, file, {})});
    }
    system.close(file);
  }
  return devices;
}

}  // namespace foreview
