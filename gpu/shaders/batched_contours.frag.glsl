#version 450 core
// Rule 2: occluders' rims. A pixel that is nearer than a neighbour across a gap carries its 1/z, else 0.
#include "batched_surface.glsl"
layout(binding = 0) uniform sampler2D surfaces;
layout(location = 0) uniform ivec2 last;  // pixel
layout(location = 1) uniform float gap;
layout(location = 0) out float rim;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 here = texelFetch(surfaces, p, 0);
  vec2 range = surface_range(here);
  vec4 right = texelFetch(surfaces, min(p + ivec2(1, 0), last), 0);
  vec4 left = texelFetch(surfaces, max(p - ivec2(1, 0), ivec2(0)), 0);
  vec4 below = texelFetch(surfaces, min(p + ivec2(0, 1), last), 0);
  vec4 above = texelFetch(surfaces, max(p - ivec2(0, 1), ivec2(0)), 0);
  bool is_rim = (right.x < here.x && is_open(here, range, right, vec2(1, 0), gap)) ||
                (left.x < here.x && is_open(here, range, left, vec2(-1, 0), gap)) ||
                (below.x < here.x && is_open(here, range, below, vec2(0, 1), gap)) ||
                (above.x < here.x && is_open(here, range, above, vec2(0, -1), gap));
  rim = is_rim ? here.x : 0.0;
}
