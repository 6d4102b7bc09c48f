// The colours of heat maps: viewer/heat_scale.h draws the same in legends.

// 0 (young) .. 1 (old): from dark blue through green to yellow, lightness rising throughout.
vec3 age_colour(float x) {
  x = clamp(x, 0.0, 1.0);
  return clamp(vec3(0.22 - 0.55 * x + 1.42 * x * x, 0.06 + 1.05 * x - 0.20 * x * x, 0.38 + 0.85 * x - 1.28 * x * x), 0.0,
               1.0);
}

// Logarithm to base 2 of the pixels that a texel covers, -3 .. 3: blue (finer than can be seen), white (a texel a
// pixel), red (too coarse).
vec3 density_colour(float octaves) {
  float x = clamp(octaves / 3.0, -1.0, 1.0);
  vec3 end = x < 0.0 ? vec3(0.10, 0.30, 0.85) : vec3(0.85, 0.12, 0.08);
  return mix(vec3(0.95), end, abs(x));
}
