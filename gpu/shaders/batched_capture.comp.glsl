#version 450 core
// When blocks of texels last took a colour, by one texel of each: rule 5 for that texel.
layout(local_size_x = 64) in;  // kPatchesPerGroup * kBlocksPerPatch
#include "batched_common.glsl"
#include "batched_patches.glsl"
#include "batched_verdict.glsl"
struct Sample {
  vec3 position;  // of the texel's centre: metres, part frame, from the part's centre
  uint polygon;   // kNone: there is no such block
};
layout(std430, binding = 13) readonly buffer Samples { Sample samples[]; };  // by patch and block of it
layout(std430, binding = 14) readonly buffer LateCharts { uint late_charts[]; };  // a bit each
layout(binding = 1) uniform sampler2D bounds;
layout(binding = 0, r32i) uniform iimage2DArray capture_times;
layout(location = 0) uniform vec2 focal_length;     // pixels
layout(location = 1) uniform vec2 principal_point;  // pixels
layout(location = 2) uniform vec2 picture_size;     // pixels
layout(location = 3) uniform float near_plane;      // metres
layout(location = 4) uniform int now;
layout(location = 5) uniform bool any_late;
layout(location = 10) uniform uint first_group;

const uint kBlocksPerPatch = 4u;
const uint kNone = 0xffffffffu;
const int kNeverCaptured = -0x7fffffff - 1;

void main() {
  uint place_in_list = first_group * kPatchesPerGroup + gl_GlobalInvocationID.x / kBlocksPerPatch;
  uint block = gl_GlobalInvocationID.x % kBlocksPerPatch;
  if (place_in_list >= commands[kTouched].count / 6u) return;
  uint index = listed_patches[place_in_list];  // kTouched is the first list
  Sample own = samples[index * kBlocksPerPatch + block];
  if (own.polygon == kNone) return;
  ivec4 place = patches[index].place;
  vec3 p = (camera_from_part[place.z] * vec4(own.position, 1.0)).xyz;
  if (p.z <= near_plane) return;
  float w = 1.0 / p.z;
  vec2 pixel = focal_length * p.xy * w + principal_point;
  if (any(lessThan(pixel, vec2(0.5))) || any(greaterThan(pixel, picture_size - 0.5))) return;
  vec2 limits = texelFetch(bounds, clamp(ivec2(pixel - 0.5), ivec2(0), ivec2(picture_size) - 2), 0).rg;
  Plane plane = planes[own.polygon];
  if (plane.range.w == 0.0 || !may_take(limits, w, plane.range.z, plane.inverse_z.w > 0.5)) return;
  ivec3 at = ivec3((patches[index].rect.xy >> 4) + ivec2(block & 1u, block >> 1), place.x);
  // A late picture only gives what was never observed.
  if (any_late && (late_charts[place.y / 32] >> (place.y % 32) & 1u) != 0u &&
      imageLoad(capture_times, at).r != kNeverCaptured) {
    return;
  }
  imageStore(capture_times, at, ivec4(now));
}
