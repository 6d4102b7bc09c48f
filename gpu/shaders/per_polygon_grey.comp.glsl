#version 450 core
// Mid grey where nothing is valid.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D colours;  // alpha: has a colour
layout(binding = 1) uniform sampler2D fused;    // alpha: observed
layout(rgba8, binding = 0) writeonly uniform image2D filled;
layout(location = 0) uniform ivec2 size;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, size))) return;
  vec4 colour = texelFetch(colours, p, 0);
  imageStore(filled, p, vec4(colour.a > 0.5 ? colour.rgb : vec3(128.0 / 255.0), texelFetch(fused, p, 0).a));
}
