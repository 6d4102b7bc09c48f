// How the textures stand to what they show; the same struct as in gpu/exposure.h.
#include "exposure_curve.glsl"
layout(std140, binding = 0) uniform Exposure {
  vec4 shown_gain;    // rgb: exposure of what is shown against that of the textures
  vec4 inverse_gain;  // 1 / exposure of the picture being extracted
};
