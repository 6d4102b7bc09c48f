#version 450 core
#include "per_polygon_common.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1) uniform usampler2D owners;
layout(binding = 2) uniform sampler2D depths;
layout(r32f, binding = 0) writeonly uniform image2D alpha;
struct Edge {
  vec4 line;    // a point, in pixels from the reference; the direction, of unit length
  vec4 extent;  // length
};
layout(std430, binding = 2) readonly buffer Edges { Edge edges[]; };
layout(std430, binding = 3) readonly buffer Neighbours { uint neighbours[]; };
layout(location = 0) uniform int slot;
layout(location = 1) uniform float near_plane;

const float kBand = 2.5;
const float kOnOutline = 1.0 / 64.0;
const float kSameSurface = 1e-4;
const float kSameSurfaceInBand = 0.02;

bool is_neighbour(uint other) {
  uvec4 lists = in_picture[slot].lists;
  for (uint i = 0u; i < lists.w; ++i) {
    if (neighbours[lists.z + i] == other) return true;
  }
  return false;
}

float judge(ivec2 pixel) {
  if (texelFetch(picture, pixel, 0).a < 0.5) return kOutside;
  uint self = uint(in_picture[slot].texture_size.z);
  vec2 here = vec2(pixel) + 0.5 - in_picture[slot].reference.xy;
  uvec4 lists = in_picture[slot].lists;
  bool inside = lists.y > 0u;
  float nearest = 1e30;  // squared distance
  vec2 foot = here;
  for (uint i = 0u; i < lists.y; ++i) {
    vec4 line = edges[lists.x + i].line;
    vec2 to_here = here - line.xy;
    if (line.z * to_here.y - line.w * to_here.x < 0.0) inside = false;
    vec2 on_edge = line.xy + line.zw * clamp(dot(to_here, line.zw), 0.0, edges[lists.x + i].extent.x);
    vec2 away = here - on_edge;
    if (dot(away, away) < nearest) {
      nearest = dot(away, away);
      foot = on_edge;
    }
  }
  if (!inside && nearest > kBand * kBand) return kOutside;

  uint owner = texelFetch(owners, pixel, 0).r;
  if (owner == self) return 1.0;
  float depth = texelFetch(depths, pixel, 0).r;
  if (inside) {
    float own = near_plane * inverse_z_at(planes[self], here);
    if (depth <= own * (1.0 + kSameSurface)) return 1.0;
    return nearest < kOnOutline * kOnOutline && is_neighbour(owner) ? 1.0 : 0.0;
  }
  if (is_neighbour(owner)) return 1.0;
  float own = near_plane * inverse_z_at(planes[self], foot);
  if (depth > own * (1.0 + kSameSurfaceInBand)) return 0.0;
  return depth >= own * (1.0 - kSameSurfaceInBand) ? 1.0 : kOutside;
}

void main() {
  ivec4 box = in_picture[slot].box;
  ivec2 in_box = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(in_box, box.zw))) return;
  imageStore(alpha, in_box, vec4(judge(box.xy + in_box)));
}
