#version 450 core
// Which patches may take a texel from the picture: those whose polygons' ball lies where the picture shows something
// of their distance.
layout(local_size_x = 64) in;
#include "batched_common.glsl"
#include "batched_patches.glsl"
layout(std430, binding = 6) readonly buffer Candidates { uint candidates[]; };
layout(std430, binding = 11) readonly buffer Slacks { float slacks[]; };  // by chart: rule 5's s, the greatest
layout(binding = 0) uniform sampler2D coarse_bounds;
layout(location = 0) uniform vec2 focal_length;     // pixels
layout(location = 1) uniform vec2 principal_point;  // pixels
layout(location = 2) uniform vec2 picture_size;     // pixels
layout(location = 3) uniform float near_plane;      // metres
layout(location = 4) uniform uint candidates_end;
layout(location = 5) uniform uint picture_number;
layout(location = 6) uniform uint list_stride;
layout(location = 7) uniform uint first_candidate;

const int kMostCells = 24;  // along an axis; larger ones are not worth asking

bool may_be_seen(Patch patch_) {
  vec3 centre = (camera_from_part[patch_.place.z] * vec4(patch_.ball.xyz, 1.0)).xyz;
  float radius = patch_.ball.w;
  if (radius < 0.0 || centre.z + radius < near_plane) return false;
  float nearest = centre.z - radius;
  if (nearest < near_plane) return true;
  // The ball's box, projected: a little larger than the ball's projection.
  vec2 least = min((centre.xy - radius) / nearest, (centre.xy - radius) / (centre.z + radius)) * focal_length;
  vec2 most = max((centre.xy + radius) / nearest, (centre.xy + radius) / (centre.z + radius)) * focal_length;
  least += principal_point;
  most += principal_point;
  if (any(lessThan(most, vec2(0.5))) || any(greaterThan(least, picture_size - 0.5))) return false;
  ivec2 last = (ivec2(picture_size) - 2) / kCoarse;
  ivec2 from = clamp(ivec2(least - 0.5) / kCoarse, ivec2(0), last);
  ivec2 to = clamp(ivec2(most - 0.5) / kCoarse, ivec2(0), last);
  if (any(greaterThan(to - from, ivec2(kMostCells)))) return true;
  vec2 hull = vec2(60000.0, 0.0);
  for (int y = from.y; y <= to.y; ++y) {
    for (int x = from.x; x <= to.x; ++x) {
      vec2 cell = texelFetch(coarse_bounds, ivec2(x, y), 0).rg;
      hull = vec2(min(hull.x, cell.x), max(hull.y, cell.y));
    }
  }
  float slack = slacks[patch_.place.y];
  return 1.0 / nearest + slack >= hull.x && 1.0 / (centre.z + radius) - slack <= hull.y;
}

void main() {
  uint candidate = first_candidate + gl_GlobalInvocationID.x;
  if (candidate >= candidates_end) return;
  uint index = candidates[candidate];
  if (!may_be_seen(patches[index])) return;
  patch_flags[index] = picture_number | (patch_flags[index] == 0u ? kFirstTime : 0u);
  uint place = atomicAdd(commands[kTouched].count, 6u) / 6u;
  listed_patches[kTouched * list_stride + place] = index;
  if (place % kPatchesPerGroup == 0u) atomicAdd(touched_groups, 1u);
}
