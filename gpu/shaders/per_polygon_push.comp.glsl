#version 450 core
// One level down the pyramid: what is not valid takes the coarser level's colour, bilinearly. Validity stays in alpha.
// BASE: from the fused texture into the filled one; else in place.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D coarse;
#ifdef BASE
layout(binding = 1) uniform sampler2D fused;
layout(rgba8, binding = 0) writeonly uniform image2D fine;
#else
layout(rgba32f, binding = 0) uniform image2D fine;
#endif
layout(location = 0) uniform ivec2 fine_size;
layout(location = 1) uniform ivec2 coarse_size;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, fine_size))) return;
#ifdef BASE
  vec4 own = texelFetch(fused, p, 0);
#else
  vec4 own = imageLoad(fine, p);
#endif
  if (own.a < 0.5) {
    ivec2 close = p / 2;
    ivec2 other = clamp(close + 2 * (p & 1) - 1, ivec2(0), coarse_size - 1);
    own.rgb = 0.5625 * texelFetch(coarse, close, 0).rgb + 0.1875 * texelFetch(coarse, ivec2(other.x, close.y), 0).rgb +
              0.1875 * texelFetch(coarse, ivec2(close.x, other.y), 0).rgb + 0.0625 * texelFetch(coarse, other, 0).rgb;
  }
  imageStore(fine, p, own);
}
