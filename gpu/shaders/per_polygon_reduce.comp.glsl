#version 450 core
// Alpha at half the size: the mean of 2x2, where <= 3/4 is nothing (spec 5, eq. 5.1).
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D fine;
layout(r32f, binding = 0) writeonly uniform image2D coarse;
layout(location = 0) uniform ivec2 fine_size;
layout(location = 1) uniform ivec2 coarse_size;

const float kOutside = 31.0 / 32.0;

float alpha_at(ivec2 p) {
  return any(greaterThanEqual(p, fine_size)) ? kOutside : texelFetch(fine, p, 0).r;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, coarse_size))) return;
  ivec2 q = 2 * p;
  float mean = 0.25 * (alpha_at(q) + alpha_at(q + ivec2(1, 0)) + alpha_at(q + ivec2(0, 1)) + alpha_at(q + ivec2(1, 1)));
  imageStore(coarse, p, vec4(mean <= 0.75 ? 0.0 : mean));
}
