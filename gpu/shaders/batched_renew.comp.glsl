#version 450 core
// Which patches must be filled anew, and their level 4.
layout(local_size_x = 64) in;
#include "batched_patches.glsl"
#include "batched_charts.glsl"
layout(std430, binding = 6) readonly buffer Candidates { uint candidates[]; };
layout(binding = 0) uniform sampler2DArray filled;  // level 4; alpha 1: changed
layout(binding = 1) uniform sampler2DArray pulled;  // level 4
layout(binding = 0, rgba8) writeonly uniform image2DArray shown;
layout(location = 4) uniform uint candidates_end;
layout(location = 5) uniform uint picture_number;
layout(location = 6) uniform uint list_stride;
layout(location = 7) uniform uint first_candidate;

void main() {
  uint candidate = first_candidate + gl_GlobalInvocationID.x;
  if (candidate >= candidates_end) return;
  uint index = candidates[candidate];
  Patch own = patches[index];
  ChartBlock chart = charts[own.place.y];
  bool touched = is_touched(index, picture_number);
  bool first_time = touched && (patch_flags[index] & kFirstTime) != 0u;
  ivec2 first = own.rect.xy >> 4, size = own.rect.zw >> 4;
  ivec2 chart_first = chart.block.xy >> 4, chart_last = chart_first + (chart.block.zw >> 4) - 1;
  bool changed = false, padded = false;
  float observed = 0.0;
  for (int y = -1; y <= size.y; ++y) {
    for (int x = -1; x <= size.x; ++x) {
      ivec3 at = ivec3(clamp(first + ivec2(x, y), chart_first, chart_last), own.place.x);
      vec4 colour = texelFetch(filled, at, 0);
      changed = changed || colour.a > 0.5;
      if (x < 0 || y < 0 || x == size.x || y == size.y) continue;
      float coverage = texelFetch(pulled, at, 0).a;
      padded = padded || coverage < 1.0;
      observed += 256.0 * coverage;
      imageStore(shown, at, vec4(colour.rgb, coverage));
    }
  }
  // Texels that no picture can reach (around the polygons) need not be filled at level 0, nor at the others with every
  // picture. A few that the areas' rounding hides keep the fill they have.
  bool holes = observed < 0.99 * own.extent.x - 4.0;
  bool renew = (padded && changed) || first_time;
  if (renew) listed_patches[kRenewed * list_stride + atomicAdd(commands[kRenewed].count, 6u) / 6u] = index;
  if (renew && (holes || first_time)) listed_patches[kHoled * list_stride + atomicAdd(commands[kHoled].count, 6u) / 6u] = index;
}
