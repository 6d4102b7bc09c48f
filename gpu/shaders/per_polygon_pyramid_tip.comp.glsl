#version 450 core
// The pyramid above a small level (32 x 32, say), up and down again, by one work group: small levels cost more in
// dispatches than in work. Leaves the top's colour in the polygon's state.
// BASE: that level is the fused texture itself, and the filled one is written; else a level of the pyramid, in place.
layout(local_size_x = 128) in;
#ifdef BASE
layout(binding = 0) uniform sampler2D fused;
layout(rgba8, binding = 0) writeonly uniform image2D base;
#else
layout(rgba32f, binding = 0) uniform image2D base;
#endif
layout(location = 0) uniform ivec2 base_size;
layout(location = 1) uniform int polygon;   // -1: no state is to be written
layout(location = 2) uniform bool down;     // else only up, for the state
layout(std430, binding = 5) writeonly buffer States { vec4 states[]; };

const float kMidGrey = 128.0 / 255.0;
shared vec4 texels[2030];  // all levels, one after the other; what GL grants, less the rest
shared ivec3 levels[12];   // width, height, place of the first texel
shared int top;

void main() {
  const int me = int(gl_LocalInvocationID.x), all = int(gl_WorkGroupSize.x);
  if (me == 0) {
    ivec3 level = ivec3(base_size, 0);
    int k = 0;
    levels[0] = level;
    while (level.x > 1 || level.y > 1) {
      level = ivec3((level.xy + 1) / 2, level.z + level.x * level.y);
      levels[++k] = level;
    }
    top = k;
  }
  for (int i = me; i < base_size.x * base_size.y; i += all) {
    ivec2 p = ivec2(i % base_size.x, i / base_size.x);
#ifdef BASE
    texels[i] = texelFetch(fused, p, 0);
#else
    texels[i] = imageLoad(base, p);
#endif
  }
  barrier();

  for (int k = 1; k <= top; ++k) {
    ivec3 fine = levels[k - 1], coarse = levels[k];
    for (int i = me; i < coarse.x * coarse.y; i += all) {
      ivec2 first = 2 * ivec2(i % coarse.x, i / coarse.x);
      ivec2 last = min(first + 1, fine.xy - 1);
      vec4 sum = vec4(0.0);
      for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
          vec4 child = texels[fine.z + y * fine.x + x];
          if (child.a > 0.5) sum += vec4(child.rgb, 1.0);
        }
      }
      texels[coarse.z + i] = sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
    }
    barrier();
  }
  if (me == 0) {
    vec4 mean = texels[levels[top].z];
    if (mean.a < 0.5) {
      texels[levels[top].z].rgb = vec3(kMidGrey);
    } else if (polygon >= 0) {
      states[polygon] = vec4(mean.rgb, 1.0);
    }
  }
  if (!down) return;
  barrier();

  for (int k = top - 1; k >= 0; --k) {
    ivec3 fine = levels[k], coarse = levels[k + 1];
    for (int i = me; i < fine.x * fine.y; i += all) {
      vec4 own = texels[fine.z + i];
      if (own.a < 0.5) {
        ivec2 p = ivec2(i % fine.x, i / fine.x);
        ivec2 close = p / 2;
        ivec2 other = clamp(close + 2 * (p & 1) - 1, ivec2(0), coarse.xy - 1);
        vec3 a = texels[coarse.z + close.y * coarse.x + close.x].rgb;
        vec3 b = texels[coarse.z + close.y * coarse.x + other.x].rgb;
        vec3 c = texels[coarse.z + other.y * coarse.x + close.x].rgb;
        vec3 d = texels[coarse.z + other.y * coarse.x + other.x].rgb;
        texels[fine.z + i].rgb = 0.5625 * a + 0.1875 * (b + c) + 0.0625 * d;
      }
    }
    barrier();
  }
  for (int i = me; i < base_size.x * base_size.y; i += all) {
    imageStore(base, ivec2(i % base_size.x, i / base_size.x), texels[i]);
  }
}
