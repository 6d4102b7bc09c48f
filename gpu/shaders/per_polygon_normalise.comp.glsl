#version 450 core
// Spec 6 and 7 in one step: what is seen now is written, what is not stays as it is.
#include "per_polygon_common.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D picture;
layout(binding = 1) uniform sampler2D alpha;
layout(rgba8, binding = 0) uniform image2D fused;
layout(location = 0) uniform int slot;
layout(location = 1) uniform float near_plane;
layout(location = 2) uniform bool keep_valid;  // the picture is older than the texture
#ifdef COUNT
layout(std430, binding = 4) buffer Counter { uint observed; };
#endif

// Adds the bilinear sample at a position in the box; false where it is not all valid.
bool add_sample(vec2 in_box, inout vec3 sum) {
  ivec4 box = in_picture[slot].box;
  vec2 position = in_box - 0.5;
  ivec2 p = ivec2(floor(position));
  if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p + 1, box.zw))) return false;
  vec4 alphas = vec4(texelFetch(alpha, p, 0).r, texelFetch(alpha, p + ivec2(1, 0), 0).r,
                     texelFetch(alpha, p + ivec2(0, 1), 0).r, texelFetch(alpha, p + ivec2(1, 1), 0).r);
  if (any(lessThanEqual(alphas, vec4(kOutside)))) return false;
  vec2 f = position - vec2(p);
  ivec2 q = box.xy + p;
  sum += mix(mix(texelFetch(picture, q, 0).rgb, texelFetch(picture, q + ivec2(1, 0), 0).rgb, f.x),
             mix(texelFetch(picture, q + ivec2(0, 1), 0).rgb, texelFetch(picture, q + ivec2(1, 1), 0).rgb, f.x), f.y);
  return true;
}

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = in_picture[slot].texture_size.xy;
  if (any(greaterThanEqual(texel, size))) return;
  vec3 u_row = in_picture[slot].u_row.xyz, v_row = in_picture[slot].v_row.xyz, z_row = in_picture[slot].z_row.xyz;
  vec2 side = 1.0 / vec2(size);
  vec3 st = vec3((vec2(texel) + 0.5) * side, 1.0);
  float z = dot(z_row, st);
  if (!(z > near_plane)) return;
  vec2 uv = vec2(dot(u_row, st), dot(v_row, st)) / z;
  ivec4 box = in_picture[slot].box;
  vec2 box_from_reference = in_picture[slot].reference.xy - vec2(box.xy);
  // The centre's projection lies between those of the cells: where it is outside, they cannot all be inside.
  vec2 centre = uv + box_from_reference;
  if (any(lessThan(centre, vec2(0.0))) || any(greaterThan(centre, vec2(box.zw)))) return;
  if (keep_valid && imageLoad(fused, texel).a > 0.5) return;

  vec2 along_s = (vec2(u_row.x, v_row.x) - uv * z_row.x) * (side.x / z);
  vec2 along_t = (vec2(u_row.y, v_row.y) - uv * z_row.y) * (side.y / z);
  float cells = clamp(ceil(max(length(along_s), length(along_t)) - 0.001), 1.0, 4.0);
  vec3 sum = vec3(0.0);
  for (float j = 0.5; j < cells; j += 1.0) {
    for (float i = 0.5; i < cells; i += 1.0) {
      vec3 cell = vec3((vec2(texel) + vec2(i, j) / cells) * side, 1.0);
      float cell_z = dot(z_row, cell);
      if (!(cell_z > near_plane)) return;
      if (!add_sample(vec2(dot(u_row, cell), dot(v_row, cell)) / cell_z + box_from_reference, sum)) return;
    }
  }
  imageStore(fused, texel, vec4(sum / (cells * cells), 1.0));
#ifdef COUNT
  atomicAdd(observed, 1u);
#endif
}
