#pragma once
#include <string_view>

namespace foreview::synthetic {

/// How much ink lies at a point of a line of capital letters (5 x 7 dots each, 6 dots apart), 0..1. The line begins at
/// (0, 0), x to the right and y up; `dot` is a dot's width in metres. Edges are softened over half a dot, so that
/// nothing finer than a dot is drawn. Characters: A-Z 0-9 space . - / : % +
[[nodiscard]] float lettering_ink(std::string_view text, float x, float y, float dot);
/// Width of a line in metres.
[[nodiscard]] float lettering_width(std::string_view text, float dot);

}  // namespace foreview::synthetic
