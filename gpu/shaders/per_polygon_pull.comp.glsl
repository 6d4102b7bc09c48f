#version 450 core
// One level up the pyramid: the mean of the valid children (spec 9, eq. 5.6-5.9).
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D fine;
layout(rgba32f, binding = 0) writeonly uniform image2D coarse;
layout(location = 0) uniform ivec2 fine_size;
layout(location = 1) uniform ivec2 coarse_size;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, coarse_size))) return;
  ivec2 first = 2 * p;
  ivec2 last = min(first + 1, fine_size - 1);
  vec4 sum = vec4(0.0);
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      vec4 child = texelFetch(fine, ivec2(x, y), 0);
      if (child.a > 0.5) sum += vec4(child.rgb, 1.0);
    }
  }
  imageStore(coarse, p, sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0));
}
