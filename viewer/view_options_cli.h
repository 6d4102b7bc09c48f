#pragma once
#include <string>
#include <vector>

#include "foreview/viewer/view_choice.h"

namespace CLI {
class App;
}

namespace foreview {

/// Adds to a subcommand all that a ViewChoice holds: --view, --split, --quality, --edges, --holes, --never-seen, --age,
/// --age-span, --texel-density, --wireframe, --cone, --polygon, --camera-mode, --camera-pose, --camera-turn, --fov.
/// `choice` keeps its values where an option is not given, and must live until the app has been parsed. Values that
/// cannot be are InputErrors naming the option, thrown while the app is being parsed.
void add_view_options(CLI::App& command, ViewChoice& choice);

/// The options that bring this choice about, without those at their defaults: what add_view_options() reads gives the
/// choice back, up to the rounding of angles between degrees and radians.
[[nodiscard]] std::vector<std::string> to_view_arguments(const ViewChoice& choice);

/// "x y z qx qy qz qw" (metres; commas do as well as blanks), as TUM trajectories have it; the quaternion is normalised
/// and must be of unit length within 1e-2. InputError naming `option`.
[[nodiscard]] Pose parse_pose(const std::string& text, const std::string& option);
/// What parse_pose() reads back exactly, but for the quaternion's last digit.
[[nodiscard]] std::string to_text(const Pose& pose);

}  // namespace foreview
