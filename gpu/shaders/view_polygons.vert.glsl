#version 450 core
// The textured model as the operator sees it: see viewer/predicted_view.h.

layout(location = 0) in vec3 position;  // metres, part frame, from the part's centre
layout(location = 1) in vec2 texel;     // from the chart's origin
layout(location = 2) in uint polygon;
layout(location = 3) in uint part;

layout(std430, binding = 0) readonly buffer Parts { mat4 clip_from_part[]; };

out vec2 chart_texel;
flat out uint polygon_index;

#ifdef FAST
// Read once a corner instead of once a pixel.
#include "view_chart_table.glsl"
layout(std430, binding = 2) readonly buffer PolygonStates { vec4 polygon_states[]; };
flat out vec4 polygon_state;
flat out vec4 chart_block;    // origin, size
flat out vec3 chart_inside;   // valid, page
#endif

#ifdef OVERLAYS
layout(std430, binding = 4) readonly buffer SpotlightParts { mat4 spotlight_from_part[]; };
out vec4 spotlight_position;
#endif

void main() {
  gl_Position = clip_from_part[part] * vec4(position, 1.0);
  chart_texel = texel;
  polygon_index = polygon;
#ifdef FAST
  polygon_state = polygon_states[polygon];
  chart_block = vec4(charts[polygon].origin, charts[polygon].size);
  chart_inside = vec3(charts[polygon].valid, charts[polygon].page);
#endif
#ifdef OVERLAYS
  spotlight_position = spotlight_from_part[part] * vec4(position, 1.0);
#endif
}
