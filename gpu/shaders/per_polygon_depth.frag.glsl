#version 450 core
#include "per_polygon_common.glsl"
layout(location = 1) uniform float near_plane;
flat in uint polygon;
layout(location = 0) out uint owner;

void main() {
  // From the plane itself and not from the rasteriser, whose corners are rounded to parts of a pixel: the occlusion
  // test computes the same expression.
  Plane plane = planes[polygon];
  gl_FragDepth = near_plane * inverse_z_at(plane, gl_FragCoord.xy - plane.reference.xy);
  owner = polygon;
}
