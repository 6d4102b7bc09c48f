#version 450 core
// Rule 7: down from the tip. At level 4 (LAST), a colour that hardly changes stays as it is, so that what hangs on it
// need not be made anew; alpha tells which ones changed.
layout(binding = 0) uniform sampler2DArray coarser;
layout(binding = 1) uniform sampler2DArray pulled;
layout(binding = 2) uniform sampler2DArray shown;
flat in int v_page;
flat in ivec4 v_rect, v_other;
layout(location = 0) out vec4 filled;

const float kHysteresis = 1.5 / 255.0;

vec3 coarse_colour(ivec2 p) {
  return texelFetch(coarser, ivec3(v_other.xy + clamp(p, ivec2(0), v_other.zw - 1), 0), 0).rgb;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec2 place = 0.5 * (vec2(at - v_rect.xy) + 0.5) - 0.5;
  ivec2 p = ivec2(floor(place));
  vec2 f = place - vec2(p);
  vec3 enlarged = mix(mix(coarse_colour(p), coarse_colour(p + ivec2(1, 0)), f.x),
                      mix(coarse_colour(p + ivec2(0, 1)), coarse_colour(p + ivec2(1, 1)), f.x), f.y);
#ifdef LAST
  vec4 own = texelFetch(pulled, ivec3(at, v_page), 0);
  vec3 colour = mix(enlarged, own.rgb, min(1.0, 2.0 * own.a));
  vec4 before = texelFetch(shown, ivec3(at, v_page), 0);
  bool changed = any(greaterThan(abs(colour - before.rgb), vec3(kHysteresis))) || own.a != before.a;
  filled = vec4(changed ? colour : before.rgb, changed ? 1.0 : 0.0);
#else
  vec4 own = texelFetch(pulled, ivec3(at, 0), 0);
  filled = vec4(mix(enlarged, own.rgb, min(1.0, 2.0 * own.a)), 1.0);
#endif
}
