#version 450 core
// Mid grey where the polygon itself has a hole, and where such a hole goes on beyond its outline, as far as fine levels
// filter. Elsewhere beyond the outline the filled colours stay: they are never shown, but coarse levels mix them with
// what is.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D fused;  // alpha: observed
layout(rgba8, binding = 0) writeonly uniform image2D filled;
layout(std430, binding = 6) readonly buffer Edges { vec4 edges[]; };  // texels: inward normal, offset, unused
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 own_edges;  // first, count

// Not 0: edges that run through texels' centres would leave it to rounding.
const float kMargin = 0.25;
const float kReach = 2.0;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, size)) || texelFetch(fused, p, 0).a > 0.5) return;
  vec2 centre = vec2(p) + 0.5;
  vec2 within = centre;
  float beyond = 0.0;
  for (int i = 0; i < own_edges.y; ++i) {
    vec4 edge = edges[own_edges.x + i];
    beyond = max(beyond, -dot(edge.xy, centre) - edge.z);
    within += edge.xy * max(1.0 - dot(edge.xy, within) - edge.z, 0.0);
  }
  if (beyond > kReach) return;
  if (beyond > kMargin && texelFetch(fused, clamp(ivec2(floor(within)), ivec2(0), size - 1), 0).a > 0.5) return;
  imageStore(filled, p, vec4(vec3(128.0 / 255.0), 0.0));
}
