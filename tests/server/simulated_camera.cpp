#include "server/simulated_camera.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

namespace foreview {
namespace {

constexpr std::uint32_t kPage = 4096;
constexpr unsigned char kPoison = 0xdb;

std::uint32_t bytes_of_pixel(std::uint32_t fourcc) {
  if (fourcc == V4L2_PIX_FMT_GREY) return 1;
  return fourcc == V4L2_PIX_FMT_YUYV || fourcc == V4L2_PIX_FMT_UYVY ? 2 : 0;
}

}  // namespace

SimulatedCamera::SimulatedCamera() {
  format_.width = 8;
  format_.height = 4;
  format_.pixelformat = V4L2_PIX_FMT_YUYV;
  format_.field = V4L2_FIELD_NONE;
}

SimulatedCamera::~SimulatedCamera() {
  for (const Memory& memory : memories_) ::munmap(memory.address, memory.length);
}

int SimulatedCamera::violation(const std::string& text, int error) {
  violations.push_back(text);
  return error;
}

int SimulatedCamera::open(const std::string& path, int flags) {
  if (path != "/dev/video0" || !is_plugged_) return -ENOENT;
  if (open_error != 0) return open_error;
  if ((flags & O_NONBLOCK) == 0) violations.emplace_back("open without O_NONBLOCK: a dequeue could block for ever");
  if ((flags & O_ACCMODE) != O_RDWR) violations.emplace_back("open without O_RDWR");
  ++open_files;
  ++opened;
  file_ = next_file_++;
  files_[file_] = true;
  return file_;
}

int SimulatedCamera::close(int file) {
  if (files_.erase(file) == 0) return violation("close of what is not open", -EBADF);
  --open_files;
  if (file != file_) return 0;
  stream_off();
  if (std::any_of(memories_.begin(), memories_.end(), [](const Memory& memory) { return memory.is_mapped; })) {
    violations.emplace_back("close with memory still mapped");
  }
  free_buffers();
  file_ = -1;
  return 0;
}

void SimulatedCamera::unplug() {
  is_plugged_ = false;
  for (auto& [file, is_there] : files_) is_there = false;
}

void SimulatedCamera::plug_in() {
  is_plugged_ = true;
}

void SimulatedCamera::at(Duration moment, std::function<void()> event) {
  events_.emplace(monotonic_ + moment, std::move(event));
}

Timestamp SimulatedCamera::now(clockid_t clock) {
  return clock == CLOCK_REALTIME ? monotonic_ + wall_offset : monotonic_;
}

int SimulatedCamera::ioctl(int file, unsigned long request, void* argument) {
  const auto found = files_.find(file);
  if (found == files_.end()) return violation("ioctl on what is not open", -EBADF);
  if (!found->second) return -ENODEV;
  if (auto& errors = failing[request]; !errors.empty()) {
    const int error = errors.front();
    errors.pop_front();
    if (error != 0) {
      if (request == VIDIOC_DQBUF && failed_dequeue_takes_buffer && !done_.empty()) {
        buffers_[done_.front()].state = BufferState::dequeued;
        done_.pop_front();
        ++discarded;
      }
      return error;
    }
  }
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& answer = *static_cast<v4l2_capability*>(argument);
      std::copy_n(card.begin(), std::min(card.size(), sizeof answer.card), answer.card);
      answer.capabilities = capabilities | V4L2_CAP_DEVICE_CAPS | V4L2_CAP_META_CAPTURE;
      answer.device_caps = capabilities;
      return 0;
    }
    case VIDIOC_ENUM_FMT:
      return enumerate_format(*static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return enumerate_size(*static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enumerate_interval(*static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_G_FMT:
      static_cast<v4l2_format*>(argument)->fmt.pix = format_;
      return 0;
    case VIDIOC_S_FMT:
      return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      if (!knows_rates) return -ENOTTY;
      auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      if (request == VIDIOC_S_PARM) {
        if (is_streaming_) return violation("S_PARM while streaming", -EBUSY);
        if (capture.timeperframe.numerator > 0 && capture.timeperframe.denominator > 0)
          interval_ = capture.timeperframe;
      }
      capture.capability = V4L2_CAP_TIMEPERFRAME;
      capture.timeperframe = interval_;
      return 0;
    }
    case VIDIOC_REQBUFS:
      return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return query_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return dequeue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      return stream_on(*static_cast<int*>(argument));
    case VIDIOC_STREAMOFF:
      return stream_off();
    default:
      return violation("an ioctl that cameras need not have: " + std::to_string(request), -ENOTTY);
  }
}

int SimulatedCamera::enumerate_format(v4l2_fmtdesc& argument) const {
  std::vector<std::uint32_t> formats;
  for (const Mode& mode : modes) {
    if (std::find(formats.begin(), formats.end(), mode.fourcc) == formats.end()) formats.push_back(mode.fourcc);
  }
  if (argument.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || argument.index >= formats.size()) return -EINVAL;
  argument.pixelformat = formats[argument.index];
  return 0;
}

int SimulatedCamera::enumerate_size(v4l2_frmsizeenum& argument) const {
  if (!lists_sizes) return -ENOTTY;
  std::vector<const Mode*> sizes;
  for (const Mode& mode : modes) {
    if (mode.fourcc == argument.pixel_format) sizes.push_back(&mode);
  }
  if (argument.index >= (is_stepwise ? 1 : sizes.size())) return -EINVAL;
  if (is_stepwise) {
    argument.type = V4L2_FRMSIZE_TYPE_STEPWISE;
    argument.stepwise = {16, sizes[0]->width, 16, 16, sizes[0]->height, 2};
  } else {
    argument.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    argument.discrete = {sizes[argument.index]->width, sizes[argument.index]->height};
  }
  return 0;
}

int SimulatedCamera::enumerate_interval(v4l2_frmivalenum& argument) const {
  if (!lists_rates) return -ENOTTY;
  for (const Mode& mode : modes) {
    if (mode.fourcc != argument.pixel_format) continue;
    if (!is_stepwise && (mode.width != argument.width || mode.height != argument.height)) continue;
    if (is_stepwise) {
      if (argument.index > 0) return -EINVAL;
      argument.type = V4L2_FRMIVAL_TYPE_CONTINUOUS;
      argument.stepwise = {{1, 120}, {1, 1}, {1, 1}};
      return 0;
    }
    if (argument.index >= mode.intervals.size()) return -EINVAL;
    argument.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    argument.discrete = mode.intervals[argument.index];
    return 0;
  }
  return -EINVAL;
}

int SimulatedCamera::set_format(v4l2_format& argument) {
  if (argument.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return violation("S_FMT of another type", -EINVAL);
  if (is_held_by_another) return -EBUSY;
  if (!buffers_.empty()) return violation("S_FMT with buffers allocated", -EBUSY);
  // Drivers do not refuse: they take the nearest that they have.
  v4l2_pix_format& pixels = argument.fmt.pix;
  const auto distance = [&](const Mode& mode) {
    if (is_stepwise) return mode.fourcc == pixels.pixelformat ? 0L : 1L;
    return (mode.fourcc == pixels.pixelformat ? 0L : 1'000'000L) + std::labs(long{mode.width} - long{pixels.width}) +
           std::labs(long{mode.height} - long{pixels.height});
  };
  const Mode& mode = *std::min_element(modes.begin(), modes.end(),
                                       [&](const Mode& a, const Mode& b) { return distance(a) < distance(b); });
  pixels.pixelformat = mode.fourcc;
  if (!is_stepwise) {
    pixels.width = mode.width;
    pixels.height = mode.height;
  }
  pixels.field = V4L2_FIELD_NONE;
  const std::uint32_t row = pixels.width * bytes_of_pixel(mode.fourcc);
  pixels.bytesperline = row == 0 ? 0 : row + padding;
  pixels.sizeimage = row == 0 ? std::max(pixels.width * pixels.height, 8192U) : pixels.bytesperline * pixels.height;
  adjust_format(argument);
  format_ = pixels;
  return 0;
}

std::uint32_t SimulatedCamera::buffer_length() const {
  return (format_.sizeimage + kPage - 1) / kPage * kPage;
}

int SimulatedCamera::request_buffers(v4l2_requestbuffers& argument) {
  if (argument.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || argument.memory != V4L2_MEMORY_MMAP) {
    return violation("REQBUFS of another type or memory", -EINVAL);
  }
  if (is_held_by_another) return -EBUSY;
  if (is_streaming_) return violation("REQBUFS while streaming", -EBUSY);
  if (std::any_of(buffers_.begin(), buffers_.end(), [](const Buffer& buffer) { return buffer.is_mapped; })) {
    return violation("REQBUFS with buffers mapped", -EBUSY);
  }
  free_buffers();
  argument.count = std::min(argument.count, most_buffers);
  for (std::uint32_t i = 0; i < argument.count; ++i) {
    const std::size_t length = buffer_length();
    void* const address = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    memories_.push_back({static_cast<unsigned char*>(address), length, false});
    Buffer buffer;
    buffer.memory = memories_.size() - 1;
    buffers_.push_back(buffer);
  }
  return 0;
}

void SimulatedCamera::free_buffers() {
  buffers_.clear();
  queue_.clear();
  done_.clear();
}

bool SimulatedCamera::is_for_capture(const v4l2_buffer& argument) {
  return argument.type == V4L2_BUF_TYPE_VIDEO_CAPTURE && argument.memory == V4L2_MEMORY_MMAP;
}

int SimulatedCamera::query_buffer(v4l2_buffer& argument) {
  if (!is_for_capture(argument) || argument.index >= buffers_.size())
    return violation("QUERYBUF of no buffer", -EINVAL);
  const Buffer& buffer = buffers_[argument.index];
  argument.length = buffer_length();
  argument.m.offset = argument.index * 0x100000;
  argument.flags = buffer.is_mapped ? V4L2_BUF_FLAG_MAPPED : 0;
  if (buffer.state == BufferState::queued) argument.flags |= V4L2_BUF_FLAG_QUEUED;
  if (buffer.state == BufferState::done) argument.flags |= V4L2_BUF_FLAG_DONE;
  return 0;
}

void* SimulatedCamera::mmap(std::size_t length, int file, std::int64_t offset, int& error) {
  error = -EINVAL;
  const auto found = files_.find(file);
  const auto index = static_cast<std::size_t>(offset / 0x100000);
  if (found == files_.end() || offset % 0x100000 != 0 || index >= buffers_.size() || length != buffer_length()) {
    violations.emplace_back("mmap of no buffer");
    return nullptr;
  }
  error = -ENODEV;
  if (!found->second) return nullptr;
  ++mappings;
  buffers_[index].is_mapped = true;
  memories_[buffers_[index].memory].is_mapped = true;
  return memories_[buffers_[index].memory].address;
}

int SimulatedCamera::munmap(void* address, std::size_t length) {
  for (std::size_t i = 0; i < memories_.size(); ++i) {
    Memory& memory = memories_[i];
    if (memory.address != address || !memory.is_mapped || memory.length != length) continue;
    memory.is_mapped = false;
    --mappings;
    for (Buffer& buffer : buffers_) {
      if (buffer.memory == i) buffer.is_mapped = false;
    }
    // Whoever reads it later is stopped at once.
    return ::mprotect(address, length, PROT_NONE);
  }
  return violation("munmap of what is not mapped", -EINVAL);
}

int SimulatedCamera::queue_buffer(v4l2_buffer& argument) {
  if (!is_for_capture(argument) || argument.index >= buffers_.size()) return violation("QBUF of no buffer", -EINVAL);
  Buffer& buffer = buffers_[argument.index];
  if (buffer.state != BufferState::dequeued) return violation("QBUF of a queued buffer", -EINVAL);
  buffer.state = BufferState::queued;
  queue_.push_back(argument.index);
  // The buffer is the driver's now: whoever still reads it reads this.
  if (buffer.is_mapped) std::memset(memories_[buffer.memory].address, kPoison, memories_[buffer.memory].length);
  return 0;
}

int SimulatedCamera::dequeue_buffer(v4l2_buffer& argument) {
  if (!is_for_capture(argument)) return violation("DQBUF of another type or memory", -EINVAL);
  if (!is_streaming_) return violation("DQBUF without streaming", -EINVAL);
  if (done_.empty()) return -EAGAIN;
  Buffer& buffer = buffers_[done_.front()];
  argument = buffer.answer;
  argument.index = static_cast<std::uint32_t>(done_.front());
  done_.pop_front();
  buffer.state = BufferState::dequeued;
  return 0;
}

int SimulatedCamera::stream_on(int type) {
  if (type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return violation("STREAMON of another type", -EINVAL);
  if (buffers_.empty()) return violation("STREAMON without buffers", -EINVAL);
  if (is_streaming_) return 0;
  is_streaming_ = true;
  sequence_ = 0;
  next_frame_ = monotonic_ + Duration::from_seconds(1 / rate());
  return 0;
}

int SimulatedCamera::stream_off() {
  is_streaming_ = false;
  discarded += done_.size();
  queue_.clear();
  done_.clear();
  for (Buffer& buffer : buffers_) buffer.state = BufferState::dequeued;
  return 0;
}

int SimulatedCamera::poll(pollfd* files, std::size_t count, int timeout_ms) {
  if (interrupted_polls > 0) {
    --interrupted_polls;
    return -EINTR;
  }
  const Timestamp deadline = monotonic_ + Duration{std::int64_t{timeout_ms} * 1'000'000};
  if (count == 0) {
    advance_to(deadline);
    return 0;
  }
  while (true) {
    const auto found = files_.find(files->fd);
    files->revents = 0;
    if (found == files_.end()) {
      files->revents = POLLNVAL;
    } else if (!found->second) {
      files->revents = POLLERR | POLLHUP;
    } else if (!done_.empty()) {
      files->revents = POLLIN;
    } else if (!is_streaming_ || queue_.empty()) {
      files->revents = POLLERR;
    }
    if (files->revents != 0) return 1;
    if (monotonic_ >= deadline) return 0;
    advance_to(std::min(deadline, next_event()));
  }
}

Timestamp SimulatedCamera::next_event() const {
  Timestamp next{std::numeric_limits<std::int64_t>::max()};
  if (is_streaming_ && is_plugged_) next = next_frame_;
  if (!events_.empty()) next = std::min(next, events_.begin()->first);
  return next;
}

void SimulatedCamera::advance_to(Timestamp moment) {
  while (next_event() <= moment) {
    monotonic_ = std::max(monotonic_, next_event());
    if (!events_.empty() && events_.begin()->first <= monotonic_) {
      const std::function<void()> event = std::move(events_.begin()->second);
      events_.erase(events_.begin());
      event();
    } else {
      deliver();
    }
  }
  monotonic_ = std::max(monotonic_, moment);
}

void SimulatedCamera::deliver() {
  next_frame_ = next_frame_ + Duration::from_seconds(1 / rate());
  if (is_silent) return;
  const std::uint32_t number = sequence_++;
  if (queue_.empty()) {
    ++overruns;
    return;
  }
  const Frame frame = make_frame(*this, number);
  const std::size_t index = queue_.front();
  queue_.pop_front();
  done_.push_back(index);
  Buffer& buffer = buffers_[index];
  const Memory& memory = memories_[buffer.memory];
  buffer.state = BufferState::done;
  const std::size_t length = std::min(frame.bytes.size(), memory.length);
  if (memory.is_mapped) std::copy_n(frame.bytes.begin(), length, memory.address);
  const std::int64_t stamp_us = frame.stamp_us.value_or((monotonic_ - transfer).nanoseconds / 1000);
  buffer.answer = {};
  buffer.answer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.answer.memory = V4L2_MEMORY_MMAP;
  buffer.answer.bytesused = frame.bytes_used.value_or(static_cast<std::uint32_t>(length));
  buffer.answer.flags = frame.flags | stamp_flags | V4L2_BUF_FLAG_MAPPED;
  buffer.answer.sequence = frame.sequence.value_or(number);
  buffer.answer.timestamp.tv_sec = stamp_us / 1'000'000;
  buffer.answer.timestamp.tv_usec = stamp_us % 1'000'000;
  buffer.answer.length = static_cast<std::uint32_t>(memory.length);
  ++filled;
}

SimulatedCamera::Frame SimulatedCamera::good_frame(SimulatedCamera& camera, std::uint32_t number) {
  Frame frame;
  const v4l2_pix_format& format = camera.format_;
  if (bytes_of_pixel(format.pixelformat) == 0) {
    frame.bytes = camera.mjpeg(number);
    return frame;
  }
  frame.bytes.resize(std::size_t{format.bytesperline} * format.height, 0xee);
  for (std::uint32_t y = 0; y < format.height; ++y) {
    for (std::uint32_t x = 0; x < format.width * bytes_of_pixel(format.pixelformat); ++x) {
      frame.bytes[y * format.bytesperline + x] = static_cast<unsigned char>(16 * y + x + number);
    }
  }
  return frame;
}

std::vector<unsigned char> SimulatedCamera::mjpeg(std::uint32_t number) const {
  cv::Mat picture(static_cast<int>(format_.height), static_cast<int>(format_.width), CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<unsigned char>(5 * x), static_cast<unsigned char>(7 * y),
                                              static_cast<unsigned char>(10 * number));
    }
  }
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes);
  return bytes;
}

}  // namespace foreview
