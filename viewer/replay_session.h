#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "foreview/viewer/replayer.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// What `foreview replay` has beyond ReplayOptions.
struct ReplaySessionOptions {
  Duration delay;            ///< as in ReplayOptions
  double near_plane = 0.02;  ///< metres
  double speed = 1;          ///< window: recorded seconds per second
  bool loop = false;         ///< window: begin anew at the end
  ViewChoice choice;
  std::filesystem::path out;  ///< where pictures go
  std::size_t every = 1;      ///< headless: only every Nth picture's instant
  std::string at;             ///< headless: only this position (Recording::parse_position); empty: pictures' instants
};

/// What became of a replay.
struct ReplaySummary {
  std::size_t pictures_written = 0;
  std::size_t instants_without_state = 0;  ///< headless: skipped because nothing was recorded there
};

/// Stamps of the operator's camera's pictures within the replay's time, and their indices.
struct ReplayInstant {
  std::size_t index = 0;
  Timestamp stamp;
};
[[nodiscard]] std::vector<ReplayInstant> replay_instants(Replayer& replayer);

/// Writes out/MODE/STEM.png for every instant, or out/MODE/at-SECONDSs.png for --at, whole files only. The same input
/// gives the same bytes. Throws Interrupted on Ctrl-C.
[[nodiscard]] ReplaySummary replay_headless(Replayer& replayer, const ReplaySessionOptions& options);

}  // namespace foreview
