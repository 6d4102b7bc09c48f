#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>

#include "foreview/viewer/live_feed.h"
#include "foreview/viewer/replayer.h"
#include "foreview/viewer/view_choice.h"

namespace CLI {
class App;
}

namespace foreview {

/// What `view --topic --headless` does: frames of live streams at a steady rate beside extraction, without a window;
/// some of them saved.
struct LiveHeadlessOptions {
  LiveFeed::Options live;
  ReplayOptions replay;  ///< what is said of textures and extraction
  ViewChoice choice;
  std::optional<double> rate;            ///< hertz; none: 60, and 33 where the CPU draws
  std::optional<ViewQuality> quality;    ///< of frames that are not saved; none: quality_that_fits()
  std::optional<Duration> duration;      ///< none: until interrupted
  std::optional<Duration> until_silent;  ///< end when no picture has come for so long, after the first
  std::optional<int> width, height;      ///< of frames that are not saved; none: the camera's
  std::filesystem::path out;             ///< where pictures go; empty: none are saved
  std::size_t every = 1;                 ///< every Nth picture of the operator's camera is saved when first shown ...
  std::optional<Duration> every_time;    ///< ... or instead, a frame as often as this
  std::optional<std::filesystem::path> pacing, json;
};

/// --headless, --duration, --until-silent, --size, --every, --pacing. `headless` and `options` must live until the app
/// has been parsed. Values that cannot be are InputErrors naming the option.
void add_live_headless_options(CLI::App& command, bool& headless, LiveHeadlessOptions& options);

/// Makes its contexts itself. A frame is saved as out/VIEW/SECONDS.png, named by the display time in the robot's clock:
/// drawn once more in the camera's own size and as --quality says, whole files only. Prints a summary unless `quiet`;
/// writes --pacing, --json and --save-textures also where the user ends it. InputError where something cannot be used.
void view_live_headless(const LiveHeadlessOptions& options, bool quiet);

}  // namespace foreview
