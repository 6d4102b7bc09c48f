#pragma once
#include "foreview/scene/timestamp.h"

namespace foreview {

/// How long ago this process was started, as the kernel counts it: to a hundredth of a second. Zero where it does not
/// say.
[[nodiscard]] Duration process_age();

}  // namespace foreview
