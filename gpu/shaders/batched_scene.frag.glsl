#version 450 core
// The surface at a pixel, from the plane itself and not from the rasteriser, whose corners are rounded to parts of a
// pixel.
layout(location = 1) uniform vec2 principal_point;
flat in vec4 v_plane;
flat in vec2 v_range;
layout(location = 0) out vec4 surface;  // 1/z, its slopes along u and v, range as two half floats

void main() {
  float w = dot(v_plane.xy, gl_FragCoord.xy - principal_point) + v_plane.z;
  surface = vec4(clamp(w, v_range.x, v_range.y), v_plane.xy, uintBitsToFloat(packHalf2x16(v_range)));
}
