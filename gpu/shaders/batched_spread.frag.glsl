#version 450 core
// Rule 3: one diamond pass, the largest 1/z of the pixel and its edge neighbours.
layout(binding = 0) uniform sampler2D rims;
layout(location = 0) uniform ivec2 last;  // pixel
layout(location = 0) out float spread;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  float own = texelFetch(rims, p, 0).r;
  float right = texelFetch(rims, min(p + ivec2(1, 0), last), 0).r;
  float left = texelFetch(rims, max(p - ivec2(1, 0), ivec2(0)), 0).r;
  float below = texelFetch(rims, min(p + ivec2(0, 1), last), 0).r;
  float above = texelFetch(rims, max(p - ivec2(0, 1), ivec2(0)), 0).r;
  spread = max(max(max(right, left), max(below, above)), own);
}
