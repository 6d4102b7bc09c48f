#version 450 core
#include "timer_work.glsl"
layout(location = 0) uniform int rounds;
layout(location = 0) out vec4 result;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(timer_work(uint(p.x + 31 * p.y), rounds));
}
