#version 450 core
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D before;
layout(r32f, binding = 0) writeonly uniform image2D after;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform float alpha_c;

const float kOutside = 31.0 / 32.0;

float alpha_at(ivec2 p) {
  if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) return kOutside;
  return texelFetch(before, p, 0).r;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, size))) return;
  float own = texelFetch(before, p, 0).r;
  float sum = alpha_at(p + ivec2(1, 0)) + alpha_at(p - ivec2(1, 0)) + alpha_at(p + ivec2(0, 1)) +
              alpha_at(p - ivec2(0, 1));
  imageStore(after, p, vec4(sum <= alpha_c ? 0.0 : own));
}
