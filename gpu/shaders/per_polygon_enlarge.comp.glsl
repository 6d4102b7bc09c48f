#version 450 core
// Alpha back at twice the size, bilinearly, where <= 15/16 is nothing (spec 5, eq. 5.2). With `last`, the enlarged
// image only decides which texels of `own` survive.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D coarse;
layout(binding = 1) uniform sampler2D own;
layout(r32f, binding = 0) writeonly uniform image2D fine;
layout(location = 0) uniform ivec2 coarse_size;
layout(location = 1) uniform ivec2 fine_size;
layout(location = 2) uniform bool last;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, fine_size))) return;
  ivec2 close = p / 2;
  ivec2 other = clamp(close + 2 * (p & 1) - 1, ivec2(0), coarse_size - 1);
  float enlarged = 0.5625 * texelFetch(coarse, close, 0).r + 0.1875 * texelFetch(coarse, ivec2(other.x, close.y), 0).r +
                   0.1875 * texelFetch(coarse, ivec2(close.x, other.y), 0).r + 0.0625 * texelFetch(coarse, other, 0).r;
  if (enlarged <= 0.9375) enlarged = 0.0;
  imageStore(fine, p, vec4(last && enlarged > 0.0 ? texelFetch(own, p, 0).r : enlarged));
}
