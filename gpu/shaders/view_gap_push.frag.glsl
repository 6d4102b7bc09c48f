#version 450 core
// Back to a finer level: its own mean where something was known below it, else the coarser level's.
layout(binding = 0) uniform sampler2D pulled;
layout(binding = 1) uniform sampler2D pulled_depth;
layout(binding = 2) uniform sampler2D coarser;  // bilinear, filled
layout(location = 0) uniform bool has_coarser;
layout(location = 0) out vec4 filled;  // colour, depth

// A little that is known near by is better than much that is far off.
const float kEnough = 1.0 / 64.0;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 own = texelFetch(pulled, at, 0);
  filled = vec4(own.rgb, texelFetch(pulled_depth, at, 0).r) / own.a;
  if (has_coarser) {
    vec4 enlarged = textureLod(coarser, 0.5 * gl_FragCoord.xy / vec2(textureSize(coarser, 0)), 0.0);
    filled = mix(enlarged, filled, min(own.a / kEnough, 1.0));
  }
}
