#version 450 core
#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
#endif
// A list's patches as squares at a level of their charts.
#include "batched_patches.glsl"
#include "batched_charts.glsl"
layout(location = 0) uniform uint list;
layout(location = 1) uniform uint list_stride;
layout(location = 2) uniform int level;
layout(location = 3) uniform float texels_to_clip;  // 2 / the page's size at this level
layout(location = 4) uniform int page;              // only this one; not with LAYERED
flat out int v_page;
flat out vec4 v_chart;  // the chart's block at the next coarser level: least and greatest place of a bilinear sample

void main() {
  Patch own = patches[listed_patches[list * list_stride + uint(gl_VertexID) / 6u]];
  int corner = gl_VertexID % 6;
  ivec2 step = ivec2(corner == 1 || corner == 2 || corner == 4, corner == 2 || corner == 4 || corner == 5);
  vec2 texel = vec2((own.rect.xy + own.rect.zw * step) >> level);
  gl_Position = vec4(texel * texels_to_clip - 1.0, 0.0, 1.0);
  v_page = own.place.x;
#ifdef LAYERED
  gl_Layer = own.place.x;
#else
  if (own.place.x != page) gl_Position = vec4(-2.0, -2.0, 0.0, 1.0);
#endif
  ivec4 block = charts[own.place.y].block;
  v_chart = vec4(vec2(block.xy >> (level + 1)) + 0.5, vec2((block.xy + block.zw) >> (level + 1)) - 0.5);
}
