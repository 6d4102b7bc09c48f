#version 450 core
// Rule 3: one diamond pass, the largest 1/z of the pixel and its edge neighbours. With TWICE two passes at once: all
// pixels up to two steps away.
layout(binding = 0) uniform sampler2D rims;
layout(location = 0) uniform ivec2 last;  // pixel
layout(location = 0) out float spread;

float rim(int x, int y) { return texelFetch(rims, clamp(ivec2(gl_FragCoord.xy) + ivec2(x, y), ivec2(0), last), 0).r; }

void main() {
  spread = max(rim(0, 0), max(max(rim(1, 0), rim(-1, 0)), max(rim(0, 1), rim(0, -1))));
#ifdef TWICE
  spread = max(spread, max(max(rim(2, 0), rim(-2, 0)), max(rim(0, 2), rim(0, -2))));
  spread = max(spread, max(max(rim(1, 1), rim(-1, 1)), max(rim(1, -1), rim(-1, -1))));
#endif
}
