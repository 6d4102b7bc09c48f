#version 450 core
#include "view_known.glsl"
layout(binding = 0) uniform sampler2D view;
layout(binding = 1) uniform sampler2D view_depth;  // reversed: goes as 1/z
layout(binding = 2) uniform sampler2D filled;      // bilinear, half the view's size
layout(binding = 3) uniform sampler2D around;      // bilinear, pulled_depth: pixels as wide as a crack may be
layout(location = 0) uniform ivec2 origin;         // of the view, in the framebuffer
layout(location = 1) uniform bool unseen;           // polygons' gaps are filled, too
layout(location = 0) out vec4 colour;

// How much is known of polygons around, where a crack begins and where it certainly is one; beside a straight edge it is
// half of them. Where nothing was seen behind it, there is less to lose.
const vec2 kCrack = vec2(0.35, 0.55), kUnseenCrack = vec2(0.2, 0.5);
// Parts of 1/z by which a hole, or a polygon that was never seen, may be off what would fill it, and by which it
// certainly is another surface: then its own chart's fill is the better guess. Wide, because this is for models that are
// off what pictures show, where up to a quarter off was found no worse (kitchen: 17 instead of 23/255).
const vec2 kOtherThanHole = vec2(0.3, 0.6), kOtherThanNeverSeen = vec2(0.6, 1.2);

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - origin;
  vec4 own = texelFetch(view, at, 0);
  if (own.a >= 1.0 || (!unseen && !is_behind(own.a))) discard;
  vec2 place = vec2(at) + 0.5;
  vec4 around_it = textureLod(filled, 0.5 * place / vec2(textureSize(filled, 0)), 0.0);
  float known = textureLod(around, place / vec2(textureSize(view, 0)), 0.0).g;
  float in_crack = smoothstep(kCrack.x, kCrack.y, known);
  float stays;
  if (is_behind(own.a)) {
    stays = 1.0 - mix(smoothstep(kUnseenCrack.x, kUnseenCrack.y, known), in_crack, share_behind(own.a));
  } else {
    float depth = texelFetch(view_depth, at, 0).r;
    float off = abs(around_it.a - depth) / max(depth, 1e-9);
    vec2 other = own.a < 1.5 / 255.0 ? kOtherThanNeverSeen : kOtherThanHole;
    stays = smoothstep(other.x, other.y, off);
    // At a crack's rim, too.
    if (is_polygon(own.a)) stays = mix(min(stays, 1.0 - in_crack), 1.0, share_of_polygon(own.a));
  }
  if (stays > 0.999) discard;
  colour = vec4(mix(around_it.rgb, own.rgb, stays), 1.0);
}
