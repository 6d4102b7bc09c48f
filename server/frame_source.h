#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "foreview/scene/camera_frame.h"

namespace foreview {

/// A picture that has arrived, with all that is known of its capture.
struct IncomingFrame {
  CameraFrame frame;
  std::size_t camera = 0;        ///< which of the source's cameras
  std::size_t index = 0;         ///< of the picture: in a recording its place there, live a number that counts up
  Timestamp received;            ///< in the time of the source's stamps
  std::uint64_t generation = 0;  ///< see FrameSource::generation()
  bool is_history = false;       ///< arrived before the last seek's moment; sent after it, newest first
};

/// What has become of one camera's pictures.
struct PictureCounts {
  std::size_t in = 0, used = 0, overwritten = 0, damaged = 0, stateless = 0, duplicated = 0,
              lost = 0;  ///< as in SourceStatus, where `in` is pictures_in
};

/// How a source is doing. Counts are since it began and never go back.
struct SourceStatus {
  std::uint64_t generation = 0;
  std::size_t pictures_in = 0;  ///< arrived, history not included: = used + overwritten + damaged + stateless + the
                                ///< few that are being decoded or wait to be taken (or were, at a seek)
  std::size_t used = 0;         ///< taken, history not included
  std::size_t history = 0;      ///< taken, of history
  std::size_t overwritten = 0;  ///< a newer one came before they were taken
  std::size_t damaged = 0;      ///< not whole, not decodable, wrong size
  std::size_t stateless = 0;    ///< pose or model state at capture not known (in time)
  std::size_t duplicated = 0;   ///< came twice, not counted as arrived
  std::size_t lost = 0;         ///< on the way, as far as that is known
  std::vector<PictureCounts> cameras;       ///< the same by camera (live); may be empty
  std::size_t bytes_decoded = 0;            ///< memory held by decoded pictures now
  std::optional<Timestamp> newest_capture;  ///< of what arrived in this generation
  std::optional<Timestamp> last_received;   ///< when the last picture arrived, in this generation
  std::optional<Timestamp> last_heard;      ///< when anything came last (live), in the time of the stamps
  Timestamp now;                            ///< the source's time when this was asked
  Duration expected_delay;                  ///< from capture to arrival: what is no cause for alarm
  bool is_decoding = false;                 ///< there is something to decode now
  bool ended = false;                       ///< nothing more will come unless it is played again
  std::string error;                        ///< what keeps pictures from coming (one line); empty: nothing known
};

/// Where pictures come from: a recording, or a live stream. Thread-safe; no member waits for a picture or for decoding.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// The newest unread picture; with several cameras, of the one that waited longest. Poll it: at times it gives none
  /// although there is one, rather than wait for another thread.
  [[nodiscard]] virtual std::optional<IncomingFrame> take() = 0;
  /// The same, but no history.
  [[nodiscard]] virtual std::optional<IncomingFrame> take_new() { return take(); }
  /// M_d and P_d at a moment of the source's time; none where not known.
  [[nodiscard]] virtual std::optional<PredictedState> predicted_state(Timestamp t) const = 0;
  /// The operator's camera as the pictures taken show it to be: predictions fit pictures when drawn with it. None: as
  /// camera_model() has it.
  [[nodiscard]] virtual std::optional<CameraModel> registered_camera() const { return std::nullopt; }
  [[nodiscard]] virtual SourceStatus status() = 0;

  /// The source's time (that of its stamps) at a moment of std::chrono::steady_clock: what is now, or will be when a
  /// frame is seen. For a recording, the display's time; live, the robot's.
  [[nodiscard]] virtual Timestamp time_at(Timestamp steady) const = 0;
  /// Nobody can stop its time, and the other side may fall silent.
  [[nodiscard]] virtual bool is_live() const { return false; }
  /// Counts up when all that arrived becomes void (seek, loop, another stream): begin the textures afresh then.
  [[nodiscard]] virtual std::uint64_t generation() const = 0;

  [[nodiscard]] virtual std::size_t cameras() const = 0;
  /// A camera's model; none until it is known (live).
  [[nodiscard]] virtual std::optional<CameraModel> camera_model(std::size_t camera) const = 0;
};

/// std::chrono::steady_clock as a Timestamp: what FrameSource::time_at() takes.
[[nodiscard]] Timestamp steady_now();

}  // namespace foreview
