#pragma once
#include <filesystem>
#include <optional>

#include "foreview/server/simulated_link.h"
#include "foreview/viewer/replayer.h"
#include "foreview/viewer/view_choice.h"

namespace CLI {
class App;
}

namespace foreview {

/// What `replay --headless --rate` does: frames at a rate, without a display, beside extraction, and a record of when
/// they were complete.
struct ReplayPacingOptions {
  std::optional<double> rate;  ///< frames a second
  Duration duration{20'000'000'000};
  int width = 800, height = 600;       ///< of a frame, pixels
  std::optional<ViewQuality> quality;  ///< none: quality_that_fits()
  bool extraction = true;
  bool reference = false;                     ///< before, as long each: extraction without frames, frames without it
  bool realtime = false;                      ///< enter_realtime()
  bool back_to_back = false;                  ///< the next picture whenever one can be taken, not when it arrives
  std::optional<std::filesystem::path> file;  ///< where the record goes
};

/// --rate, --duration, --size, --no-extraction, --reference, --back-to-back, --realtime, --pacing. `options` must live
/// until the app has been parsed; values that cannot be are InputErrors naming the option.
void add_pacing_options(CLI::App& command, ReplayPacingOptions& options);

/// Plays the recording, from its end on from its start again, over `link` with the replay's delay, for so long. Makes
/// its contexts itself. Prints a summary unless `quiet`, also of what there is when the user interrupts it. InputError
/// where something cannot be used.
void replay_pacing(const ReplayOptions& replay, const LinkOptions& link, const ReplayPacingOptions& options,
                   bool quiet);

}  // namespace foreview
