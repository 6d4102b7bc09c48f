#version 450 core
#include "timer_work.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f, binding = 0) writeonly uniform image2D result;
layout(location = 0) uniform int rounds;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  imageStore(result, p, vec4(timer_work(uint(p.x + 31 * p.y), rounds)));
}
