#version 450 core
// Rule 4: what 1/z a surface must have to take its colour from between four pixels. Cell (x, y) has the pixels (x, y)
// to (x + 1, y + 1) at its corners.
#include "batched_surface.glsl"
layout(binding = 0) uniform sampler2D surfaces;
layout(binding = 1) uniform sampler2D spread;
layout(binding = 2) uniform sampler2D picture;  // alpha: usable
layout(location = 0) uniform float gap;
layout(location = 1) uniform float rounding;
layout(location = 0) out vec2 bounds;  // least and greatest 1/z; the latter negative where only thin polygons may take anything

const float kNever = 60000.0;  // finite in half floats, and no surface's 1/z

void widen(inout vec2 hull, vec4 surface, vec2 range, vec2 to_centre) {
  float reach = 0.5 * (abs(surface.y) + abs(surface.z));
  float middle = surface.x + dot(surface.yz, to_centre);
  vec2 own = vec2(min(range.x, surface.x), max(range.y, surface.x));
  hull = vec2(min(hull.x, clamp(middle - reach, own.x, own.y)), max(hull.y, clamp(middle + reach, own.x, own.y)));
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 a = texelFetch(surfaces, p, 0), b = texelFetch(surfaces, p + ivec2(1, 0), 0);
  vec4 c = texelFetch(surfaces, p + ivec2(0, 1), 0), d = texelFetch(surfaces, p + ivec2(1, 1), 0);
  vec2 range_a = surface_range(a), range_b = surface_range(b), range_c = surface_range(c), range_d = surface_range(d);
  vec2 hull = vec2(kNever, 0.0);
  widen(hull, a, range_a, vec2(0.5, 0.5));
  widen(hull, b, range_b, vec2(-0.5, 0.5));
  widen(hull, c, range_c, vec2(0.5, -0.5));
  widen(hull, d, range_d, vec2(-0.5, -0.5));
  bool open = is_open(a, range_a, b, vec2(1, 0), gap) || is_open(c, range_c, d, vec2(1, 0), gap) ||
              is_open(a, range_a, c, vec2(0, 1), gap) || is_open(b, range_b, d, vec2(0, 1), gap);
  // Where nothing is, polygons seen edge-on, whose 1/z may be anything within a pixel, must not take the void's colour.
  bool never = hull.y <= 0.0;
  float own_least = hull.x * (1.0 - rounding), greatest = hull.y * (1.0 + rounding), least = own_least;
#ifdef SUPPRESS
  float nearest_rim = max(max(texelFetch(spread, p, 0).r, texelFetch(spread, p + ivec2(1, 0), 0).r),
                          max(texelFetch(spread, p + ivec2(0, 1), 0).r, texelFetch(spread, p + ivec2(1, 1), 0).r));
  least = max(least, nearest_rim * (1.0 - gap));
#endif
#ifdef DISTORTED
  float usable = min(min(texelFetch(picture, p, 0).a, texelFetch(picture, p + ivec2(1, 0), 0).a),
                     min(texelFetch(picture, p + ivec2(0, 1), 0).a, texelFetch(picture, p + ivec2(1, 1), 0).a));
  never = never || usable < 0.5;
#endif
  bool thin_only = open || least > greatest;
  bounds = never ? vec2(kNever, 0.0) : thin_only ? vec2(own_least, -greatest) : vec2(least, greatest);
}
