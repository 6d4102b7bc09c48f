#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foreview/server/capture/capture_format.h"
#include "foreview/server/capture/video_stream.h"
#include "foreview/server/capture/video_system.h"

namespace foreview {

/// What a stamp says of its picture.
enum class StampKind : std::uint8_t {
  start_of_exposure,  ///< as the driver says (V4L2_BUF_FLAG_TSTAMP_SRC_SOE); UVC: the first packet's arrival
  end_of_frame,       ///< the last of it has arrived: later by exposure, readout and transfer
  arrival,            ///< the driver does not stamp: when it was taken out here, later still
};

/// A picture as it is passed on.
struct CapturedPicture {
  std::vector<unsigned char> bytes;  ///< a JPEG with all its tables, or rows of pixels without padding
  std::string encoding;              ///< as in ROS: "jpeg", "yuv422_yuy2", "yuv422", "mono8"
  int width = 0, height = 0;
  Timestamp stamp;  ///< wall time (CLOCK_REALTIME)
  StampKind stamp_kind = StampKind::end_of_frame;
  std::uint64_t sequence = 0;  ///< from 0; what the driver says was lost is left out. Goes on over reopening
};

/// Pictures of a V4L2 camera, and a count of everything that goes wrong. Buffers are given back at once, so that the
/// driver never runs out of them because of a reader's slowness. Not thread-safe.
class V4l2Camera {
 public:
  struct Options {
    std::string device = "/dev/video0";  ///< names in /dev/v4l/by-id last longer than numbers
    CaptureWish wish = {};
    std::size_t buffers = 4;
    bool reopen = false;  ///< waits for a camera that has gone to come back
    Duration reopen_every{1'000'000'000};
    /// Begins to stream anew when no picture came for so long; 0: never, for cameras that are triggered.
    Duration stall{5'000'000'000};
    bool newest_only = true;  ///< of pictures that wait together, the newest; a queue would only make the display older
    bool stamp_on_arrival = false;  ///< where the driver does not stamp; else that is an error
    Duration stamp_shift = {};      ///< added to every stamp: from what the driver stamps to the middle of the exposure
  };

  /// = what the driver filled: delivered + overtaken + flagged + short_frames + wrong_size + damaged + bad_stamps.
  struct Statistics {
    std::size_t delivered = 0;
    std::size_t overtaken = 0;          ///< a newer one was there already
    std::size_t flagged = 0;            ///< V4L2_BUF_FLAG_ERROR: the driver says that it is damaged
    std::size_t short_frames = 0;       ///< fewer bytes than a picture has
    std::size_t wrong_size = 0;         ///< of another size than agreed
    std::size_t damaged = 0;            ///< no JPEG, or not a whole one
    std::size_t bad_stamps = 0;         ///< zero, in the future, older than 10 s, or not after the one before
    std::size_t lost = 0;               ///< gaps in the driver's numbers
    std::size_t io_errors = 0;          ///< EIO and the like, of poll and VIDIOC_DQBUF
    std::size_t buffers_recovered = 0;  ///< that neither side held after such an error
    std::size_t stalls = 0;             ///< no picture for Options::stall
    std::size_t restarts = 0;           ///< streams begun anew, the camera being there: after stalls, repeated errors
    std::size_t unplugged = 0;
    std::size_t reopened = 0;  ///< came back
    bool is_open = false;
  };

  /// Throws VideoError or InputError ("/dev/video0: is in use by another program; expected a free camera"): also with
  /// `reopen`, what is not there at the beginning is an error.
  explicit V4l2Camera(Options options, VideoSystem& system = real_video_system());

  /// The next picture. None after `timeout`, or when a signal comes: ask again. A faulty picture is dropped and
  /// counted; the wait goes on. Throws VideoError where the camera has gone or keeps failing; with `reopen` only where
  /// it comes back as another (a format or size that differs), since calibration would not hold.
  [[nodiscard]] std::optional<CapturedPicture> next(Duration timeout);

  [[nodiscard]] const Statistics& statistics() const { return statistics_; }
  /// What was agreed on.
  [[nodiscard]] const CaptureMode& mode() const { return mode_; }
  /// The camera's own name.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  struct Stamp {
    Timestamp time;
    StampKind kind = StampKind::end_of_frame;
  };
  [[nodiscard]] Timestamp now() const { return system_.now(CLOCK_MONOTONIC); }
  /// Opens the stream; false: not there (yet).
  [[nodiscard]] bool is_streaming();
  void open();
  /// False: a signal came.
  [[nodiscard]] bool sleep_until(Timestamp moment);
  /// Takes out what is ready.
  [[nodiscard]] std::optional<CapturedPicture> take_ready();
  [[nodiscard]] std::optional<CapturedPicture> read(const v4l2_buffer& buffer);
  [[nodiscard]] std::optional<Stamp> stamp_of(const v4l2_buffer& buffer);
  /// Wall time less monotonic time, measured now.
  [[nodiscard]] Duration wall_from_monotonic() const;
  void count_sequence(std::uint32_t sequence);
  void handle_error(int error);
  /// Gives up the stream, to be opened anew at once or, where that did not help, later. Throws where nothing helps.
  void restart(const std::string& why);
  void handle_unplugged();

  VideoSystem& system_;
  const Options options_;
  std::unique_ptr<VideoStream> stream_;
  CaptureMode mode_;
  std::string name_;
  Statistics statistics_;
  bool is_waiting_for_return_ = false;  ///< it was unplugged
  std::string last_refusal_;            ///< told once
  Timestamp next_attempt_;
  Timestamp last_activity_;  ///< monotonic: the last picture, whatever it was like, or the stream's beginning
  std::size_t errors_in_a_row_ = 0, restarts_in_a_row_ = 0;
  std::optional<std::uint32_t> last_driver_sequence_;
  std::optional<Timestamp> last_driver_stamp_;
  std::optional<std::uint64_t> sequence_;
};

}  // namespace foreview
