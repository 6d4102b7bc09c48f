// A pixel's surface (batched_scene.frag.glsl) continued to a place `offset` pixels away: 1/z, kept within the
// polygon's own range.
vec2 surface_range(vec4 surface) { return unpackHalf2x16(floatBitsToUint(surface.w)); }

float continued(vec4 surface, vec2 range, vec2 offset) {
  return clamp(surface.x + dot(surface.yz, offset), min(range.x, surface.x), max(range.y, surface.x));
}

// Whether two neighbouring pixels show surfaces that do not meet between them. Two polygons that share an edge do: of
// one the other's continuation is nearer at one pixel and farther at the other.
bool is_open(vec4 here, vec2 here_range, vec4 there, vec2 offset, float gap) {
  float at_here = here.x - continued(there, surface_range(there), -offset);
  float at_there = continued(here, here_range, offset) - there.x;
  return at_here * at_there > 0.0 && min(abs(at_here), abs(at_there)) > gap * max(here.x, there.x);
}
