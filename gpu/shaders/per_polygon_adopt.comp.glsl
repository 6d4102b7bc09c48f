#version 450 core
// The way back: a polygon's texture from its chart.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2DArray pages;
layout(rgba8, binding = 0) writeonly uniform image2D fused;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec4 block;  // x, y, width, height
layout(location = 2) uniform int page;
layout(location = 3) uniform vec4 columns;  // texel of the block = columns * texel + offset
layout(location = 4) uniform vec2 offset;

vec4 block_texel(ivec2 p) {
  return texelFetch(pages, ivec3(block.xy + p, page), 0);
}

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(texel, size))) return;
  vec2 centre = vec2(texel) + 0.5;
  vec2 position = columns.xy * centre.x + columns.zw * centre.y + offset;
  ivec2 last = block.zw - 1;
  if (block_texel(clamp(ivec2(floor(position)), ivec2(0), last)).a < 0.5) {
    imageStore(fused, texel, vec4(0.0));
    return;
  }
  vec2 corner = clamp(position - 0.5, vec2(0.0), vec2(last));
  ivec2 p = ivec2(corner), q = min(p + 1, last);
  vec2 f = corner - vec2(p);
  vec3 colour = mix(mix(block_texel(p).rgb, block_texel(ivec2(q.x, p.y)).rgb, f.x),
                    mix(block_texel(ivec2(p.x, q.y)).rgb, block_texel(q).rgb, f.x), f.y);
  imageStore(fused, texel, vec4(colour, 1.0));
}
