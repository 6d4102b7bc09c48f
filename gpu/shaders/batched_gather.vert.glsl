#version 450 core
#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
#endif
// Rule 5: the visible charts in texture space.
layout(location = 0) in vec3 position;  // metres, part frame, from the part's centre: the point of the texel
layout(location = 1) in uint polygon;
layout(location = 2) in uint part;
layout(location = 3) in vec2 texel;     // in the page
layout(location = 4) in uint patch_index;
#include "batched_common.glsl"
#include "batched_patches.glsl"
layout(location = 0) uniform vec2 focal_length;     // pixels
layout(location = 1) uniform vec2 principal_point;  // pixels
layout(location = 2) uniform vec2 picture_size;     // pixels
layout(location = 3) uniform float near_plane;      // metres
layout(location = 4) uniform float texels_to_clip;  // 2 / page size
layout(location = 7) uniform uint picture_number;
layout(location = 8) uniform int page;              // only this one; not with LAYERED
out float gl_ClipDistance[5];
noperspective out vec3 v_homogeneous;  // pixel times z, z; linear over the chart
flat out vec2 v_slack;                 // 1/m: how much 1/z changes within a pixel; 1 if its polygon is thin

void main() {
  vec3 p = (camera_from_part[part] * vec4(position, 1.0)).xyz;
  vec3 h = vec3(focal_length * p.xy + principal_point * p.z, p.z);
  v_homogeneous = h;
  v_slack = vec2(planes[polygon].range.z, planes[polygon].inverse_z.w);
  gl_Position = vec4(texel * texels_to_clip - 1.0, 0.0, 1.0);
  bool drawn = is_touched(patch_index, picture_number);
#ifdef LAYERED
  gl_Layer = patches[patch_index].place.x;
#else
  drawn = drawn && patches[patch_index].place.x == page;
#endif
  if (!drawn) gl_Position = vec4(-2.0, -2.0, 0.0, 1.0);
  // Only what can have four pixels around it.
  gl_ClipDistance[0] = p.z - near_plane;
  gl_ClipDistance[1] = h.x - 0.5 * h.z;
  gl_ClipDistance[2] = h.y - 0.5 * h.z;
  gl_ClipDistance[3] = (picture_size.x - 0.5) * h.z - h.x;
  gl_ClipDistance[4] = (picture_size.y - 0.5) * h.z - h.y;
}
