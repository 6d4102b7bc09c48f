#version 450 core
// Colour of a polygon at a pixel (default), with overlays over it (OVERLAYS), or with SURFACE what lies there. FAST:
// with less filtering. See viewer/predicted_view.h.

#include "capture_times.glsl"
#include "exposure.glsl"
#include "view_chart.glsl"
#include "view_known.glsl"

layout(std430, binding = 2) readonly buffer PolygonStates { vec4 polygon_states[]; };  // mean colour, seen

in vec2 chart_texel;
flat in uint polygon_index;
#ifdef FAST
flat in vec4 polygon_state;
flat in vec4 chart_block;
flat in vec3 chart_inside;
#endif

#ifdef SURFACE
layout(location = 0) out int surface_polygon;
layout(location = 1) out float surface_inverse_z;
layout(location = 2) out uint surface_provenance;  // 2 observed, 1 filled, 0 never seen
layout(location = 3) out int surface_captured;     // when: capture_times.glsl
#else
layout(location = 0) uniform uint first_backdrop;  // polygons from this one on
layout(location = 0) out vec4 colour;              // alpha: view_known.glsl
#endif

#ifdef OVERLAYS
#include "view_overlays.glsl"
#endif

// A back face can never get a texture: the model has no surface there. It keeps the polygon's mean colour, halfway to
// grey, so that it neither shows what is behind (a hole where something solid is) nor passes for a true surface.
vec3 back_face_colour(vec3 mean_colour) {
  return mix(vec3(dot(mean_colour, vec3(0.299, 0.587, 0.114))), mean_colour, 0.5);
}

vec4 own_state() {
#ifdef FAST
  return polygon_state;
#else
  return polygon_states[polygon_index];
#endif
}

vec4 own_colour(vec2 texel_per_x, vec2 texel_per_y) {
#ifdef FAST
  Chart chart = Chart(chart_block.xy, chart_block.zw, chart_inside.xy, chart_inside.z, 0.0);
  return chart_colour_fast(chart, chart_texel, texel_per_x, texel_per_y);
#else
  return chart_colour(polygon_index, chart_texel, texel_per_x, texel_per_y);
#endif
}

void main() {
  vec4 state = own_state();
  bool textured = gl_FrontFacing && state.a >= 1.0;
  vec2 texel_per_x = dFdx(chart_texel);
  vec2 texel_per_y = dFdy(chart_texel);
#ifdef SURFACE
  surface_polygon = int(polygon_index);
  surface_inverse_z = gl_FragCoord.w;
  Chart chart = charts[polygon_index];
  vec2 inside = clamp_nan_safe(chart_texel, vec2(0.5), chart.valid - 0.5);
  surface_captured = textured ? capture_time(chart.origin + inside, int(chart.page)) : kNeverCaptured;
  surface_provenance = !textured ? 0u : chart_is_observed(polygon_index, chart_texel) ? 2u : 1u;
#else
  vec3 rgb;
  float known = gl_FrontFacing ? (polygon_index < first_backdrop ? kKnownNever : 0.0) : kKnownBehind;
  if (textured) {
    vec4 own = own_colour(texel_per_x, texel_per_y);
    rgb = exposed(own.rgb, shown_gain.rgb);
    known = known_of(own.a, polygon_index >= first_backdrop);
  } else {
    vec3 mean_colour = exposed(state.rgb, shown_gain.rgb);
    rgb = gl_FrontFacing ? mean_colour : back_face_colour(mean_colour);
  }
#ifdef OVERLAYS
  rgb = with_overlays(rgb, textured, state.a, texel_per_x, texel_per_y);
#endif
  colour = vec4(rgb, known);
#endif
}
