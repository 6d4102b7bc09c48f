#version 450 core
// What is done to a predicted view once it is drawn: its difference to the truth, or its colours taken out.

layout(binding = 0) uniform sampler2D view;   // the frame, row 0 its top
layout(binding = 1) uniform sampler2D truth;  // over the viewport

layout(location = 0) uniform float gain;      // of the difference; 0: none is shown
layout(location = 1) uniform float severity;  // 0..1: how much of the colours goes

in vec2 v_uv;
layout(location = 0) out vec4 colour;

void main() {
  vec3 rgb = texelFetch(view, ivec2(gl_FragCoord.xy), 0).rgb;
  if (gain > 0.0) rgb = min(gain * abs(rgb - texture(truth, v_uv).rgb), 1.0);
  float grey = dot(rgb, vec3(0.299, 0.587, 0.114));
  // Darker, too, so that even a grey scene changes.
  rgb = mix(rgb, vec3(grey * (1.0 - 0.35 * severity)), severity);
  colour = vec4(rgb, 1.0);
}
