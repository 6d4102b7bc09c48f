#version 450 core
// Least and greatest 1/z that any cell of a square of 8 x 8 takes, be it for thin polygons only.
layout(binding = 0) uniform sampler2D bounds;
layout(location = 0) uniform ivec2 last_cell;
layout(location = 0) out vec2 coarse;

const int kCoarse = 8;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * kCoarse;
  coarse = vec2(60000.0, 0.0);
  for (int y = 0; y < kCoarse; ++y) {
    for (int x = 0; x < kCoarse; ++x) {
      vec2 own = texelFetch(bounds, min(first + ivec2(x, y), last_cell), 0).rg;
      coarse = vec2(min(coarse.x, own.x), max(coarse.y, abs(own.y)));
    }
  }
}
