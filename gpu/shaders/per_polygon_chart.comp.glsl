#version 450 core
// Each texel of the chart's block from the polygon's texture at its own point of the plane.
#include "per_polygon_common.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D filled;
layout(binding = 1) uniform sampler2D fused;  // alpha: observed
layout(rgba8, binding = 0) writeonly uniform image2D page;
layout(location = 0) uniform int slot;

void main() {
  ivec4 block = in_picture[slot].chart_block;
  ivec2 in_block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(in_block, block.zw))) return;
  vec4 columns = in_picture[slot].texel_columns;
  vec2 centre = vec2(in_block) + 0.5;
  vec2 position = columns.xy * centre.x + columns.zw * centre.y + in_picture[slot].texel_offset.xy;
  ivec2 last = in_picture[slot].texture_size.xy - 1;
  vec2 corner = clamp(position - 0.5, vec2(0.0), vec2(last));
  ivec2 p = ivec2(corner), q = min(p + 1, last);
  vec2 f = corner - vec2(p);
  vec3 colour = mix(mix(texelFetch(filled, p, 0).rgb, texelFetch(filled, ivec2(q.x, p.y), 0).rgb, f.x),
                    mix(texelFetch(filled, ivec2(p.x, q.y), 0).rgb, texelFetch(filled, q, 0).rgb, f.x), f.y);
  ivec2 containing = clamp(ivec2(floor(position)), ivec2(0), last);
  imageStore(page, block.xy + in_block, vec4(colour, texelFetch(fused, containing, 0).a));
}
