#version 450 core
// The mean colour of a chart is that of its polygons.
layout(local_size_x = 64) in;
#include "batched_tip.glsl"
layout(std430, binding = 9) buffer States { vec4 states[]; };
layout(std430, binding = 10) readonly buffer Members { uvec2 members[]; };  // polygon, chart
layout(binding = 0) uniform sampler2DArray tip;
layout(location = 0) uniform int tip_level;

void main() {
  if (gl_GlobalInvocationID.x >= members.length()) return;
  uvec2 member = members[gl_GlobalInvocationID.x];
  ivec4 rect = tip_rect(tip_level, member.y);
  vec4 mean = texelFetch(tip, ivec3(rect.xy, 0), 0);
  if (mean.a > 0.0) states[member.x] = vec4(mean.rgb, 1.0);
}
