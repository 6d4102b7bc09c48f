// What is drawn over the predicted view's surfaces, by viewer/predicted_view.h's ViewStyle.

#include "capture_times.glsl"
#include "view_scale.glsl"

layout(std140, binding = 1) uniform Overlays {
  bool holes, never_seen, age, density;
  int highlighted_polygon, highlighted_group;  // -1: none
  int moment;                                  // that the frame shows, as capture_time() counts
  float age_span;                              // seconds
  bool spotlight;
  float orientation;  // of the frame: 1 where row 0 is the picture's top, -1 where it is its bottom
};
layout(binding = 1) uniform sampler2D spotlight_depth;  // reversed, as the spotlight's camera sees the model

in vec4 spotlight_position;  // clip coordinates of the spotlight's camera

const vec3 kPink = vec3(1.0, 0.41, 0.71);
const vec3 kNeverSeen = vec3(0.55, 0.25, 0.85);
const vec3 kHighlight = vec3(0.15, 0.95, 1.0);
const vec3 kLight = vec3(0.10, 0.08, 0.01);
const float kUnlit = 0.5;
const float kRim = 0.03;         // of the picture's width and height, over which the light fades
const float kTolerance = 0.003;  // of the depth: what lies this little behind the spotlight's surface is still lit

// Two bands of stripes over the frame, 6 pixels wide, that lean to the right.
bool on_stripe() { return mod(gl_FragCoord.x + orientation * gl_FragCoord.y, 12.0) < 6.0; }

// How much of the spotlight falls here, 0 to 1: inside the picture of its camera, on a side that faces it, and hidden by
// nothing. On a plane the camera's depth is linear in its picture: so this surface's depth at the centres of the four
// texels around is exact, and needs no slope's worth of tolerance.
float spotlight_at(bool front) {
  vec2 at = 0.5 + 0.5 * spotlight_position.xy / spotlight_position.w;
  float depth = spotlight_position.z / spotlight_position.w;
  vec2 at_x = dFdx(at), at_y = dFdy(at);
  float depth_x = dFdx(depth), depth_y = dFdy(depth);
  float turn = at_x.x * at_y.y - at_x.y * at_y.x;
  vec2 inside = min(at, 1.0 - at);
  if (!(spotlight_position.w > 0.0 && min(inside.x, inside.y) > 0.0 && front && turn * orientation > 0.0)) return 0.0;
  vec2 slope = vec2(depth_x * at_y.y - depth_y * at_x.y, depth_y * at_x.x - depth_x * at_y.x) / turn;
  vec2 size = vec2(textureSize(spotlight_depth, 0));
  vec2 texel = at * size - 0.5;
  vec2 corner = floor(texel), weight = texel - corner;
  vec4 stored = textureGather(spotlight_depth, (corner + 1.0) / size);  // lower left, lower right, right, origin
  vec2 first = (corner + 0.5) / size - at, last = (corner + 1.5) / size - at;
  vec4 own = depth + vec4(dot(slope, vec2(first.x, last.y)), dot(slope, last), dot(slope, vec2(last.x, first.y)),
                          dot(slope, first));
  vec4 lit = vec4(greaterThanEqual(own, stored * (1.0 - kTolerance)));
  float seen = mix(mix(lit.w, lit.z, weight.x), mix(lit.x, lit.y, weight.x), weight.y);
  vec2 rim = smoothstep(0.0, kRim, inside);
  return seen * rim.x * rim.y;
}

// The colour of the age of what is shown here; grey where it is not known.
vec3 colour_of_age() {
  Chart chart = charts[polygon_index];
  vec2 t = clamp_nan_safe(chart_texel, vec2(0.5), chart.valid - 0.5);
  int captured = capture_time(chart.origin + t, int(chart.page));
  return captured == kNeverCaptured ? vec3(0.5) : age_colour(float(moment - captured) * 1e-3 / age_span);
}

// Pixels that a texel covers along its longest extent in the frame.
float pixels_per_texel(vec2 texel_per_x, vec2 texel_per_y) {
  float xx = dot(texel_per_x, texel_per_x), yy = dot(texel_per_y, texel_per_y), xy = dot(texel_per_x, texel_per_y);
  float mean = 0.5 * (xx + yy);
  float shortest = mean - sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  return inversesqrt(max(shortest, 1e-8));
}

vec3 with_overlays(vec3 rgb, bool textured, float seen, vec2 texel_per_x, vec2 texel_per_y) {
  float grey = dot(rgb, vec3(0.299, 0.587, 0.114));
  if (age || density) {
    // Both: in turn, by stripes. The picture stays visible in the lightness.
    bool show_age = age && (!density || on_stripe());
    vec3 heat = vec3(0.5);
    if (textured) {
      heat = show_age ? colour_of_age()
                      : density_colour(log2(pixels_per_texel(texel_per_x, texel_per_y)));
    }
    rgb = mix(vec3(grey), heat, 0.75);
  }
  if (holes && !(textured && chart_is_observed(polygon_index, chart_texel))) rgb = kPink;
  if (never_seen && !(gl_FrontFacing && seen >= 1.0)) rgb = on_stripe() ? kNeverSeen : mix(rgb, kNeverSeen, 0.35);
  if (highlighted_group >= 0 && int(charts[polygon_index].group) == highlighted_group) {
    rgb = mix(rgb, kHighlight, int(polygon_index) == highlighted_polygon ? 0.5 : 0.22);
  }
  if (spotlight) {
    float light = spotlight_at(gl_FrontFacing);
    rgb = mix(rgb * kUnlit, rgb * 1.05 + kLight, light);
  }
  return rgb;
}
