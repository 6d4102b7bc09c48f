#pragma once
#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "foreview/server/capture/video_system.h"

namespace foreview {

/// A camera at the level of system calls, with a clock of its own: what /dev/video0 does, by V4L2's rules, as long as
/// nothing is set to go wrong. What a driver would refuse because the caller broke a rule stands in `violations`.
/// Pictures are made while somebody waits in poll(), which is when time passes.
class SimulatedCamera : public VideoSystem {
 public:
  struct Mode {
    std::uint32_t fourcc = V4L2_PIX_FMT_YUYV;
    std::uint32_t width = 8, height = 4;
    std::vector<v4l2_fract> intervals{{1, 30}};
  };
  struct Frame {
    std::vector<unsigned char> bytes;
    std::uint32_t flags = 0;                  ///< beside the stamp's
    std::optional<std::uint32_t> bytes_used;  ///< what the driver says, where it lies
    std::optional<std::int64_t> stamp_us;     ///< monotonic; none: as it should be
    std::optional<std::uint32_t> sequence;
  };

  SimulatedCamera();
  ~SimulatedCamera() override;

  // What the device is like; set before it is opened.
  std::vector<Mode> modes{Mode{}};
  std::string card = "Simulated camera";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  bool lists_sizes = true, lists_rates = true, is_stepwise = false, knows_rates = true;
  std::uint32_t padding = 0;  ///< bytes after each line
  std::uint32_t most_buffers = 32;
  std::uint32_t stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  Duration transfer{12'000'000};  ///< from the stamp to the picture being there
  std::function<Frame(SimulatedCamera&, std::uint32_t number)> make_frame = &SimulatedCamera::good_frame;
  std::function<void(v4l2_format&)> adjust_format = [](v4l2_format&) {};  ///< what the driver makes of S_FMT

  // What happens.
  void unplug();
  void plug_in();
  bool is_held_by_another = false;
  bool is_silent = false;                            ///< delivers nothing
  int open_error = 0;                                ///< -errno
  std::map<unsigned long, std::deque<int>> failing;  ///< what the next ioctls of a kind answer (-errno; 0: as usual)
  bool failed_dequeue_takes_buffer = false;          ///< a picture, with an EIO of VIDIOC_DQBUF
  int interrupted_polls = 0;
  /// At a moment of simulated time.
  void at(Duration moment, std::function<void()> event);
  /// Wall time less monotonic time.
  Duration wall_offset{1'700'000'000'000'000'000};
  void advance(Duration time) { advance_to(monotonic_ + time); }

  // What came of it.
  std::vector<std::string> violations;
  std::size_t open_files = 0, mappings = 0;
  std::size_t filled = 0;     ///< buffers that the driver filled
  std::size_t overruns = 0;   ///< pictures for which there was no buffer
  std::size_t discarded = 0;  ///< filled, and taken back unread as the stream ended
  std::size_t opened = 0;
  [[nodiscard]] const v4l2_pix_format& format() const { return format_; }
  [[nodiscard]] double rate() const { return static_cast<double>(interval_.denominator) / interval_.numerator; }
  [[nodiscard]] std::size_t buffers() const { return buffers_.size(); }
  [[nodiscard]] bool is_streaming() const { return is_streaming_; }
  [[nodiscard]] Timestamp monotonic() const { return monotonic_; }

  /// Raw: byte i of line y is 16 y + i + number, the padding 0xee. MJPEG: mjpeg(number).
  [[nodiscard]] static Frame good_frame(SimulatedCamera& camera, std::uint32_t number);
  [[nodiscard]] std::vector<unsigned char> mjpeg(std::uint32_t number) const;

  int open(const std::string& path, int flags) override;
  int close(int file) override;
  int ioctl(int file, unsigned long request, void* argument) override;
  void* mmap(std::size_t length, int file, std::int64_t offset, int& error) override;
  int munmap(void* address, std::size_t length) override;
  int poll(pollfd* files, std::size_t count, int timeout_ms) override;
  Timestamp now(clockid_t clock) override;

 private:
  enum class BufferState { dequeued, queued, done };
  struct Buffer {
    BufferState state = BufferState::dequeued;
    bool is_mapped = false;
    v4l2_buffer answer{};
    std::size_t memory = 0;  ///< in memories_
  };
  struct Memory {
    unsigned char* address = nullptr;
    std::size_t length = 0;
    bool is_mapped = false;
  };
  int violation(const std::string& text, int error);
  int refuse_gone(int file) const;
  int enumerate_format(v4l2_fmtdesc& argument) const;
  int enumerate_size(v4l2_frmsizeenum& argument) const;
  int enumerate_interval(v4l2_frmivalenum& argument) const;
  int set_format(v4l2_format& argument);
  int request_buffers(v4l2_requestbuffers& argument);
  int query_buffer(v4l2_buffer& argument);
  int queue_buffer(v4l2_buffer& argument);
  int dequeue_buffer(v4l2_buffer& argument);
  int stream_on(int type);
  int stream_off();
  void free_buffers();
  [[nodiscard]] bool is_for_capture(const v4l2_buffer& argument);
  [[nodiscard]] std::uint32_t buffer_length() const;
  void advance_to(Timestamp moment);
  [[nodiscard]] Timestamp next_event() const;
  void deliver();

  Timestamp monotonic_{100'000'000'000};
  std::multimap<Timestamp, std::function<void()>> events_;
  bool is_plugged_ = true;
  int file_ = -1;  ///< of the one user
  int next_file_ = 10;
  std::map<int, bool> files_;  ///< open ones; whether their device is still there
  v4l2_pix_format format_{};
  v4l2_fract interval_{1, 30};
  std::vector<Buffer> buffers_;
  std::vector<Memory> memories_;
  std::deque<std::size_t> queue_, done_;
  bool is_streaming_ = false;
  std::uint32_t sequence_ = 0;
  Timestamp next_frame_;
};

}  // namespace foreview
