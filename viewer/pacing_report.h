#pragma once
#include <optional>
#include <string>
#include <vector>

#include "foreview/calib/registration.h"
#include "foreview/viewer/pacing.h"

namespace foreview {

struct PacingReport {
  std::string recording, renderer;
  int width = 0, height = 0;  ///< of the frames, pixels
  double delay_seconds = 0;
  std::string quality;                             ///< of the frames: full, fast
  bool realtime = false;                           ///< ran ahead of ordinary programs
  std::optional<RegistrationStatus> registration;  ///< of the last run, at its end; none: off
  std::vector<PacingRun> runs;                     ///< with frames and extraction last
};

inline constexpr int kPacingJsonVersion = 1;

/// A line on one of a run's intervals, and the heading above such lines.
[[nodiscard]] std::string pacing_text(const PacingRun::Interval& interval);
[[nodiscard]] std::string pacing_interval_heading();
/// Some lines per run, and how punctual frames are beside extraction where that was measured without, too.
[[nodiscard]] std::string pacing_text(const PacingReport& report);
/// One JSON object: "format" "foreview-pacing", "version" kPacingJsonVersion; described in docs/scheduling.md.
[[nodiscard]] std::string pacing_json(const PacingReport& report);

}  // namespace foreview
