#pragma once
#include <cstddef>
#include <string>

#include "foreview/viewer/replayer.h"

namespace CLI {
class App;
}

namespace foreview {

/// Adds to a subcommand everything that decides the predicted view of a recording: the positional RECORDING and
/// --scene, --camera, --delay, --from, --to, --history, --artefacts, --passes, --alpha-c, --small-texture, --fill,
/// --density, --max-texels, --exposure, --near, --load-textures, --save-textures. `options` keeps its values where an
/// option is not given, and must live until the app has been parsed. Values that cannot be are InputErrors naming the
/// option, thrown while the app is being parsed.
void add_replay_options(CLI::App& command, ReplayOptions& options, bool needs_recording = true);

/// Adds --pipeline and --stats, likewise.
void add_pipeline_options(CLI::App& command, ReplayOptions& options);

/// A whole number from 1 to a million; InputError naming `option`.
[[nodiscard]] std::size_t parse_count(const std::string& text, const std::string& option);

/// Adds --registration, for commands that show pictures, or measure what is shown.
void add_registration_option(CLI::App& command, ReplayOptions& options);

}  // namespace foreview
