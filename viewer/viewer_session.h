#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "foreview/server/frame_source.h"
#include "foreview/server/simulated_link.h"
#include "foreview/viewer/live_feed.h"
#include "foreview/viewer/replay_session.h"
#include "foreview/viewer/replayer.h"
#include "foreview/viewer/run_counters.h"

namespace foreview {

/// The interactive viewer of a recording, or of live streams.
struct ViewerOptions {
  std::optional<LiveFeed::Options> live;  ///< instead of a recording
  ReplayOptions replay;                   ///< live: what is said of textures and extraction
  ReplaySessionOptions session;
  LinkOptions link;                           ///< delay: replay.delay; live: in front of what comes
  std::optional<double> rate;                 ///< hertz; none: the monitor's up to 60, and 33 where the CPU draws
  bool panels = true;                         ///< to begin with
  std::optional<std::filesystem::path> json;  ///< where a summary goes
};

/// What became of it.
struct ViewerSummary {
  std::string recording, camera;            ///< recording: the feed's name
  double from_seconds = 0, to_seconds = 0;  ///< since the recording's start
  Duration first_frame_after;               ///< since the process was started
  std::size_t pictures_written = 0;
  std::size_t contexts_lost = 0;
  long objects_grown = 0;  ///< OpenGL objects made between the first picture and the end
  long objects_left = 0;   ///< not given back
  std::size_t frames = 0, frames_late = 0, frames_skipped = 0, frames_missed = 0;
  RunCounters counters;
  SourceStatus source;
  std::optional<RegistrationStatus> registration;
  std::optional<LiveReport> live;
};

/// Plays the recording in a window as if it came in live, or shows what comes in live, until the user leaves; display
/// at a steady rate, extraction beside it. A lost graphics context is made anew, the textures with it. Throws
/// WindowLost, after --save-textures was done, where the window is gone; GraphicsError and InputError where it cannot
/// begin. Ctrl-C ends it like Q: the caller sees interrupted().
[[nodiscard]] ViewerSummary view_feed(const ViewerOptions& options);

/// What `view`, and `replay` with a window, do: view_feed(), with messages, --stats and --json. Throws Interrupted
/// after Ctrl-C.
void run_viewer(const ViewerOptions& options, bool quiet);

}  // namespace foreview
