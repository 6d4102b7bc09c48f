#pragma once
#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "foreview/calib/registration.h"
#include "foreview/gpu/extraction.h"
#include "foreview/scene/timestamp.h"
#include "foreview/server/frame_source.h"
#include "foreview/viewer/live_report.h"
#include "foreview/viewer/polygon_report.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// What the viewer's panels tell of its doings. Plain values, taken anew for every frame.
struct ViewerStatus {
  std::string name;      ///< of the recording or stream
  std::string renderer;  ///< GL_RENDERER and version
  // Time, in the source's.
  Timestamp first, last, now;               ///< of the recording, if it is one; now: what is shown
  std::optional<Timestamp> newest_picture;  ///< capture of the newest picture in the textures shown
  bool extracting = false;                  ///< a picture is being extracted, or waits for it

  // Display.
  double rate_wanted = 0, rate_reached = 0;  ///< hertz
  std::size_t frames = 0, frames_late = 0, frames_skipped = 0, frames_missed = 0;
  struct Frame {
    float milliseconds = 0;  ///< from the completion of the one before to its own
    bool late = false;
  };
  std::deque<Frame> last_frames;  ///< newest last, at most kFrames
  static constexpr std::size_t kFrames = 120;

  // Extraction.
  struct Picture {
    std::array<float, kExtractionSteps> step_ms{};
    float total_ms = 0;  ///< from being taken up to being finished, the display's frames between included
  };
  std::deque<Picture> last_pictures;  ///< newest last
  static constexpr std::size_t kPictures = 48;
  double pictures_per_second = 0;
  SourceStatus source;
  std::optional<LiveReport> live;                  ///< of live streams
  std::optional<RegistrationStatus> registration;  ///< of the operator's camera; none: off

  // Memory, in bytes.
  std::size_t texture_bytes = 0;
  std::size_t process_bytes = 0;  ///< resident

  // Under the cursor, where asked for.
  std::optional<PolygonReport> polygon;
  bool polygon_found = false;
  double polygon_distance = 0;              ///< metres
  std::optional<Timestamp> texel_captured;  ///< of the colour under the cursor

  bool truth_known = false;  ///< ViewMode::difference has something to compare with
  std::string message;       ///< what was done last ("saved ..."), for a few seconds
  bool message_is_error = false;
};

/// "1:02.50" from a minute on, else "12.34 s".
[[nodiscard]] std::string time_text(Duration time);
/// "320 ms", "1.25 s", "34 s": a figure that one reads at a glance.
[[nodiscard]] std::string age_text(Duration age);
/// "48 MiB", "1.2 GiB".
[[nodiscard]] std::string bytes_text(std::size_t bytes);
/// "no limit", "500 kbit/s", "8 Mbit/s".
[[nodiscard]] std::string bandwidth_text(double bits_per_second);
/// 12345 as "12,345".
[[nodiscard]] std::string count_text(std::size_t count);
/// The window's title: what is shown, when, and what is special.
struct TitleInput {
  std::string name;
  ViewMode mode = ViewMode::predicted;
  Duration since_first;
  Duration delay;
  double rate = 0;
  bool paused = false, at_end = false;
  bool live = false;            ///< no time of its own, no delay that was chosen
  std::optional<Duration> age;  ///< live: of the newest picture
  bool extracting = false;      ///< only told of where time stands: else it is always so
};
[[nodiscard]] std::string viewer_title(const TitleInput& input);
/// The upper end of a plot's axis: the smallest of 1, 2, 5, 10, 20, 50 ... that is not below `greatest`.
[[nodiscard]] double plot_top(double greatest);

/// Bytes of memory that the process occupies now; 0 where the system does not tell.
[[nodiscard]] std::size_t resident_bytes();

}  // namespace foreview
