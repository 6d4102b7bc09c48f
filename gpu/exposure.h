#pragma once
#include <cmath>

namespace foreview {

/// What the exposure of a picture does to a channel of its colours, 0..1: multiplies it by `gain`, ever less the
/// brighter it is, so that black stays black and white white: a camera's saturated highlights are so at any exposure
/// near its own, and nothing is clipped. exposed(exposed(c, g), 1 / g) is c, exposed(c, 1) exactly c, and exposures
/// compose: gain^4 is a factor of c^4 / (1 - c^4). The same as in shaders/exposure_curve.glsl.
[[nodiscard]] inline float exposed(float colour, float gain) {
  const float c2 = colour * colour, g2 = gain * gain;
  return colour * gain / std::sqrt(std::sqrt(1 + (g2 * g2 - 1) * c2 * c2));
}

/// How the textures of a set stand to what they show, in a buffer (GL_UNIFORM_BUFFER, std140): textures and polygon
/// states hold colours under one exposure, however the pictures' varied; shown is exposed(colour, shown).
struct Exposure {
  float shown[4] = {1, 1, 1, 0};    ///< red, green, blue: gain of the newest picture
  float inverse[4] = {1, 1, 1, 0};  ///< 1 / gain of the picture extracted last, which may have come late
  bool operator==(const Exposure&) const = default;
};

}  // namespace foreview
