#pragma once
#include <cstddef>
#include <string>

#include "foreview/viewer/replayer.h"
#include "foreview/viewer/view_choice.h"

namespace foreview {

/// The command for a shell that writes, without a window, the picture that the viewer shows at the time of picture
/// `index` of the operator's camera.
[[nodiscard]] std::string headless_command(const ReplayOptions& replay, const ViewChoice& choice, std::size_t index);

/// As a shell takes it for one word.
[[nodiscard]] std::string shell_word(const std::string& text);

}  // namespace foreview
