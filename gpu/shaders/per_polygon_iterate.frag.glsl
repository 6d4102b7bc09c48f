#version 450 core
// One pass of the two-stage filter (spec 9; eq. 5.26-5.29). Without COPY only the texels that this pass fills are
// written, so that an occlusion query counts them.
layout(binding = 0) uniform sampler2D before;
layout(location = 0) uniform ivec2 size;
layout(location = 0) out vec4 colour;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  colour = texelFetch(before, p, 0);
#ifndef COPY
  if (colour.a > 0.5) discard;
  float close = 0.0;  // valid ones among the 8 neighbours
  vec4 sum = vec4(0.0);
  ivec2 first = max(p - 2, ivec2(0)), last = min(p + 2, size - 1);
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      vec4 other = texelFetch(before, ivec2(x, y), 0);
      if (other.a < 0.5) continue;
      sum += vec4(other.rgb, 1.0);
      if (abs(x - p.x) <= 1 && abs(y - p.y) <= 1) close += 1.0;
    }
  }
  if (close == 0.0) discard;
  colour = vec4(sum.rgb / sum.a, 1.0);
#endif
}
