#version 450 core
layout(binding = 0) uniform sampler2DArray finer;
layout(location = 4) uniform bool from_pages;
flat in int v_page;
flat in ivec4 v_rect, v_other;
layout(location = 0) out vec4 pulled;

void main() {
  ivec2 first = 2 * (ivec2(gl_FragCoord.xy) - v_rect.xy);
  vec4 sum = vec4(0.0);
  float children = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 child = first + ivec2(i & 1, i >> 1);
    if (any(greaterThanEqual(child, v_other.zw))) continue;
    vec4 texel = texelFetch(finer, ivec3(v_other.xy + child, from_pages ? v_page : 0), 0);
    sum += vec4(texel.rgb * texel.a, texel.a);
    children += 1.0;
  }
  pulled = sum.a > 0.0 ? vec4(sum.rgb / sum.a, max(sum.a / children, 1.0 / 255.0)) : vec4(0.0);
}
