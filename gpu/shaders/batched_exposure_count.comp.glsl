#version 450 core
// Rule 5: how much brighter the picture shows than the textures what has been observed before.
layout(local_size_x = 64) in;
#include "batched_common.glsl"
#include "batched_patches.glsl"
#include "batched_exposure.glsl"
#include "exposure_curve.glsl"
#include "batched_verdict.glsl"
struct Sample {
  vec3 position;  // of the texel's centre: metres, part frame, from the part's centre
  uint polygon;   // kNone: there is no sample
  vec3 along_x;   // a quarter of the texel's sides; their cross product points to the front
  uint texel;     // at level kLevel of the page: x, y << 16
  vec3 along_y;
  uint unused;
};
layout(std430, binding = 13) readonly buffer Samples { Sample samples[]; };
layout(std430, binding = 14) buffer References { vec4 references[]; };  // a sample's colour over time; alpha 0: none yet
layout(std430, binding = 6) readonly buffer Candidates { uint candidates[]; };
layout(binding = 0) uniform sampler2D picture;  // bilinear
layout(binding = 1) uniform sampler2D bounds;
layout(binding = 2) uniform sampler2DArray observed;  // level kLevel
layout(location = 0) uniform vec2 focal_length;     // pixels
layout(location = 1) uniform vec2 principal_point;  // pixels
layout(location = 2) uniform vec2 picture_size;     // pixels
layout(location = 3) uniform float near_plane;      // metres
layout(location = 4) uniform uint candidates_end;
layout(location = 5) uniform uint picture_number;
layout(location = 6) uniform vec2 pixel_to_uv;
layout(location = 7) uniform ivec2 last_cell;
layout(location = 8) uniform uint first_candidate;

const uint kNone = 0xffffffffu;
const uint kSamplesPerPatch = 4u;
const float kDarkest = 16.0 / 255.0, kBrightest = 235.0 / 255.0;  // of what can tell
const float kLimit = 0.3;     // of the logarithm of a change
const float kChanged = 0.14;  // likewise, of one that something else than exposure makes
const float kRenewal = 0.1;   // share of a remembered colour that the newest one takes
const float kUnit = 1023.0;  // of the sums

bool is_usable(vec3 colour) {
  return all(greaterThan(colour, vec3(kDarkest))) && all(lessThan(colour, vec3(kBrightest)));
}

vec3 picture_at(vec3 p) {
  return textureLod(picture, (focal_length * p.xy / p.z + principal_point) * pixel_to_uv, 0.0).rgb;
}

void main() {
  uint candidate = first_candidate + gl_GlobalInvocationID.x / kSamplesPerPatch;
  if (candidate >= candidates_end) return;
  uint index = candidates[candidate];
  if (!is_touched(index, picture_number)) return;
  Sample own = samples[index * kSamplesPerPatch + gl_GlobalInvocationID.x % kSamplesPerPatch];
  if (own.polygon == kNone) return;
  ivec2 texel = ivec2(own.texel & 0xffffu, own.texel >> 16);
  vec4 before = texelFetch(observed, ivec3(texel, patches[index].place.x), 0);
  if (before.a < 0.999) return;

  mat4 pose = camera_from_part[patches[index].place.z];
  vec3 p = (pose * vec4(own.position, 1.0)).xyz;
  vec3 x = mat3(pose) * own.along_x, y = mat3(pose) * own.along_y;
  if (p.z - abs(x.z) - abs(y.z) <= near_plane || dot(cross(x, y), p) >= 0.0) return;
  float w = 1.0 / p.z;
  vec2 pixel = focal_length * p.xy * w + principal_point;
  if (any(lessThan(pixel, vec2(1.0))) || any(greaterThan(pixel, picture_size - 1.0))) return;
  vec2 limits = texelFetch(bounds, clamp(ivec2(pixel - 0.5), ivec2(0), last_cell), 0).rg;
  if (!may_take(limits, w, planes[own.polygon].range.z, false)) return;

  uint slot = index * kSamplesPerPatch + gl_GlobalInvocationID.x % kSamplesPerPatch;
  vec4 reference = references[slot];
  reference = reference.a == 0.0 ? vec4(before.rgb, 1.0) : mix(reference, vec4(before.rgb, 1.0), kRenewal);
  references[slot] = reference;
  vec3 expected = exposed(reference.rgb, shown_gain.rgb);
  if (!is_usable(expected)) return;
  vec3 now = 0.25 * (picture_at(p - x - y) + picture_at(p + x - y) + picture_at(p - x + y) + picture_at(p + x + y));
  if (!is_usable(now)) return;
  // All that decides is the same for both, so that noise in either leans to neither side: every picture builds upon the
  // one before, and what leans adds up.
  vec3 now4 = now * now * now * now, expected4 = expected * expected * expected * expected;
  vec3 logarithm = 0.25 * log(now4 * (1.0 - expected4) / (expected4 * (1.0 - now4)));
  // What changed begins anew: creeping to its new colour, it would come to count while it is still on its way.
  if (any(greaterThan(abs(logarithm), vec3(kChanged)))) references[slot].a = 0.0;
  if (any(greaterThan(abs(logarithm), vec3(kLimit)))) return;
  uvec3 bin = min(uvec3((logarithm + kReach) * (float(kBins) / (2.0 * kReach))), uvec3(kBins - 1u));
  uvec3 weight = uvec3((0.5 * kUnit) * (now * (1.0 - now4) + expected * (1.0 - expected4)) + 0.5);
  ivec3 difference = ivec3(round(kUnit * (now - expected)));
  for (uint channel = 0u; channel < 3u; ++channel) {
    atomicAdd(weights[channel * kBins + bin[channel]], weight[channel]);
    atomicAdd(differences[channel * kBins + bin[channel]], difference[channel]);
  }
  atomicAdd(samples_taken, 1u);
}
