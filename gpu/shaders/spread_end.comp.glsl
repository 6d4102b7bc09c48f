#version 450 core
// Polygons that are not connected to any seen one take the mean of all seen; mid grey if there is none. One workgroup,
// so that the sum's order, and with it the result, is always the same.
#include "spread_common.glsl"

shared vec4 sums[64];

void main() {
  uint lane = gl_LocalInvocationID.x;
  vec4 sum = vec4(0);
  for (uint polygon = lane; polygon < polygon_count; polygon += 64u) {
    if (rims[polygon] == 0u) sum += vec4(states[polygon].rgb, 1.0);
  }
  sums[lane] = sum;
  memoryBarrierShared();
  barrier();
  vec4 total = vec4(0);
  for (int i = 0; i < 64; ++i) total += sums[i];
  bool any_seen = total.w > 0.0;
  vec4 state = any_seen ? vec4(total.rgb / total.w, 0.5) : vec4(vec3(0.5), 0.0);
  for (uint polygon = lane; polygon < polygon_count; polygon += 64u) {
    if (rims[polygon] == NOT_YET) states[polygon] = state;
  }
}
