#version 450 core
#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
#endif
// A list's charts as rectangles at a level of the tip.
#include "batched_tip.glsl"
layout(location = 0) uniform int level;
layout(location = 1) uniform vec2 texels_to_clip;  // 2 / the target's size
layout(location = 2) uniform int page;             // only this one, for level 4 without LAYERED; else -1
layout(location = 3) uniform int other_level;      // whose rectangle the fragments read
flat out int v_page;
flat out ivec4 v_rect, v_other;

void main() {
  uint chart = chart_list[gl_VertexID / 6];
  int corner = gl_VertexID % 6;
  ivec2 step = ivec2(corner == 1 || corner == 2 || corner == 4, corner == 2 || corner == 4 || corner == 5);
  v_rect = tip_rect(level, chart);
  v_other = tip_rect(other_level, chart);
  v_page = charts[chart].place.x;
  gl_Position = vec4(vec2(v_rect.xy + v_rect.zw * step) * texels_to_clip - 1.0, 0.0, 1.0);
#ifdef LAYERED
  gl_Layer = level == 4 ? v_page : 0;
#else
  if (page >= 0 && v_page != page) gl_Position = vec4(-2.0, -2.0, 0.0, 1.0);
#endif
}
