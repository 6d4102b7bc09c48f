#version 450 core
// Rule 8: the coarser level, enlarged, where nothing was observed.
layout(binding = 0) uniform sampler2DArray coarser;  // bilinear
layout(binding = 1) uniform sampler2DArray pulled;
layout(location = 5) uniform vec2 coarser_to_uv;
flat in int v_page;
flat in vec4 v_chart;
layout(location = 0) out vec4 filled;

void main() {
  vec2 place = clamp(0.5 * gl_FragCoord.xy, v_chart.xy, v_chart.zw);
  vec3 enlarged = textureLod(coarser, vec3(place * coarser_to_uv, v_page), 0.0).rgb;
#ifdef BASE
  filled = vec4(enlarged, 0.0);  // blended in where the base's alpha is 0
#else
  vec4 own = texelFetch(pulled, ivec3(gl_FragCoord.xy, v_page), 0);
  filled = vec4(mix(enlarged, own.rgb, min(1.0, 2.0 * own.a)), own.a);
#endif
}
