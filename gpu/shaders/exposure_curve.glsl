// A colour under another exposure; the same as in gpu/exposure.h.
vec3 exposed(vec3 colour, vec3 gain) {
  vec3 c2 = colour * colour, g2 = gain * gain;
  return colour * gain / sqrt(sqrt(1.0 + (g2 * g2 - 1.0) * c2 * c2));
}
