#version 450 core
// Forgets what was spread before: only seen polygons are sources.
#include "spread_common.glsl"

void main() {
  uint polygon = gl_GlobalInvocationID.x;
  if (polygon >= polygon_count) return;
  rims[polygon] = states[polygon].w == 1.0 ? 0u : NOT_YET;
}
