#version 450 core
// Rule 6: a level's texel is the mean of what was observed below it; alpha is the observed share.
layout(binding = 0) uniform sampler2DArray finer;
layout(binding = 1) uniform sampler2DArray shown_before;  // the texel that is written, which may be read once
flat in int v_page;
layout(location = 0) out vec4 pulled;
layout(location = 1) out vec4 shown;  // levels 1..3: where nothing is to be filled, this is all

vec4 weighted(ivec2 p) {
  vec4 texel = texelFetch(finer, ivec3(p, v_page), 0);
  return vec4(texel.rgb * texel.a, texel.a);
}

void main() {
  ivec2 p = 2 * ivec2(gl_FragCoord.xy);
  vec4 sum = weighted(p) + weighted(p + ivec2(1, 0)) + weighted(p + ivec2(0, 1)) + weighted(p + ivec2(1, 1));
  // What was observed stays observed: here nothing ever was, and what is shown is a fill that may stay.
  if (sum.a == 0.0) discard;
  // It must not be lost by rounding either.
  pulled = vec4(sum.rgb / sum.a, max(0.25 * sum.a, 1.0 / 255.0));
  // Otherwise mostly filled, which is made anew only if something changed.
  shown = pulled.a < 0.5 ? vec4(texelFetch(shown_before, ivec3(gl_FragCoord.xy, v_page), 0).rgb, pulled.a) : pulled;
}
