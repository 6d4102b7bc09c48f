// Reading a chart of the atlas (design 4) so that no tap ever leaves it: every bilinear tap is clamped, per level, to
// the polygon's box grown by the gutter and half a texel of its level inside the chart's block.

#include "view_chart_table.glsl"
layout(binding = 0) uniform sampler2DArray pages;  // bilinear within a level, nearest level

// Added to the level. The colours were filtered when they were extracted; a second full filter blurs too much: half a
// level finer measured 0.15 dB better on the workcell, a whole one 0.2 dB, but that would begin to flicker.
const float kSharper = -0.5;
const float kCoarsestLevel = 4.0;  // kChartLevels - 1
// 8 look no better on the workcell (0.001 dB) and cost 110 ms more of processor time a frame in software.
const float kMostTaps = 4.0;
const float kGutter = 2.0;  // kChartGutter

// Unlike min and max, defined for NaN (a pixel centre outside its polygon and beyond the horizon): the lower bound.
vec2 clamp_nan_safe(vec2 t, vec2 lower, vec2 upper) {
  return vec2(t.x >= lower.x ? min(t.x, upper.x) : lower.x, t.y >= lower.y ? min(t.y, upper.y) : lower.y);
}

vec4 chart_tap(Chart chart, vec2 t, float level) {
  float half_texel = 0.5 * exp2(level);
  t = clamp_nan_safe(t, vec2(0.5), chart.valid - 0.5);
  t = max(min(t, chart.size - half_texel), vec2(half_texel));
  return textureLod(pages, vec3((chart.origin + t) / vec2(textureSize(pages, 0).xy), chart.page), level);
}

// Mean colour, and share of what was observed, of the pixel's footprint, the parallelogram of the two derivatives:
// trilinear taps along the longer axis of its ellipse, each as wide as the shorter one, so that surfaces seen at grazing
// angles stay sharp across.
vec4 chart_colour(uint polygon, vec2 t, vec2 texel_per_x, vec2 texel_per_y) {
  Chart chart = charts[polygon];
  texel_per_x = clamp_nan_safe(texel_per_x, vec2(-1e6), vec2(1e6));
  texel_per_y = clamp_nan_safe(texel_per_y, vec2(-1e6), vec2(1e6));
  float xx = texel_per_x.x * texel_per_x.x + texel_per_y.x * texel_per_y.x;
  float yy = texel_per_x.y * texel_per_x.y + texel_per_y.y * texel_per_y.y;
  float xy = texel_per_x.x * texel_per_x.y + texel_per_y.x * texel_per_y.y;
  float mean = 0.5 * (xx + yy);
  float deviation = sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  float longer = sqrt(mean + deviation);
  float shorter = max(sqrt(max(mean - deviation, 0.0)), 1.0);
  vec2 axis = xx > yy ? vec2(mean + deviation - yy, xy) : vec2(xy, mean + deviation - xx);
  float axis_length = length(axis);
  axis = axis_length > 0.0 ? axis * (longer / axis_length) : vec2(0.0);

  float taps = clamp(ceil(longer / shorter - 0.25), 1.0, kMostTaps);
  float level = clamp(log2(max(longer / taps, shorter)) + kSharper, 0.0, kCoarsestLevel);
  // Nearer to the chart's rim than half a texel of its level, a tap would be clamped and show a place further inside: a
  // seam where a plane is cut. There a finer level, whose half texel fits, is the lesser evil.
  vec2 rim = min(t, chart.valid - t);
  float fitting_level = log2(2.0 * max(min(rim.x, rim.y), kGutter));
  if (level > fitting_level) {
    level = fitting_level;
    taps = min(ceil(longer / exp2(level)), kMostTaps);
  }
  float fine = floor(level);
  float coarse_weight = level - fine;
  vec4 sum = vec4(0.0);
  for (float i = 0.5; i < taps; i += 1.0) {
    vec2 at = t + axis * (i / taps - 0.5);
    vec4 colour = chart_tap(chart, at, fine);
    if (coarse_weight > 0.0) colour = mix(colour, chart_tap(chart, at, fine + 1.0), coarse_weight);
    sum += colour;
  }
  return sum / taps;
}

// One bilinear tap of the level that fits the footprint's mean width. In software the whole colour takes three fifths of
// the time that two taps along the footprint's axis take.
vec4 chart_colour_fast(Chart chart, vec2 t, vec2 texel_per_x, vec2 texel_per_y) {
  float width_squared = 0.5 * (dot(texel_per_x, texel_per_x) + dot(texel_per_y, texel_per_y));
  vec2 rim = max(min(t, chart.valid - t), vec2(kGutter));
  float fitting = 2.0 * min(rim.x, rim.y);
  float level = floor(0.5 * log2(min(width_squared, fitting * fitting)));
  return chart_tap(chart, t, level >= 0.0 ? min(level, kCoarsestLevel) : 0.0);
}

// Whether a picture has shown the texel that the point lies in (level 0: coarser alphas mean "anything below").
bool chart_is_observed(uint polygon, vec2 t) {
  Chart chart = charts[polygon];
  t = clamp_nan_safe(t, vec2(0.5), chart.valid - 0.5);
  return texelFetch(pages, ivec3(ivec2(chart.origin + t), int(chart.page)), 0).a >= 0.5;
}
