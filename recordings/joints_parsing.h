#pragma once
#include <string>
#include <string_view>

#include "foreview/recordings/damage_log.h"
#include "foreview/recordings/recording.h"

namespace foreview {

/// Parses joints.csv: a header "stamp,NAME,..." and lines of numbers, one per column. In order of time; damaged lines
/// are dropped and noted. Throws InputError where the header is missing or of no use. `file` names the source.
[[nodiscard]] Recording::Joints parse_joints(std::string_view text, const std::string& file, DamageLog& damage);

}  // namespace foreview
