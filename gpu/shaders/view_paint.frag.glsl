#version 450 core
#include "view_scale.glsl"

layout(binding = 0) uniform sampler2D glyphs;

in vec2 v_place;
flat in vec4 v_colour;
flat in float v_kind;  // 0: one colour, 1: text, 2: scale of ages, 3: scale of densities

layout(location = 0) out vec4 colour;

void main() {
  float covered = texture(glyphs, v_place).r;
  colour = v_colour;
  if (v_kind == 1.0) colour.a *= covered;
  if (v_kind == 2.0) colour = vec4(age_colour(v_place.x), 1.0);
  if (v_kind == 3.0) colour = vec4(density_colour(6.0 * v_place.x - 3.0), 1.0);
}
