#version 450 core
// Rule 1 of BatchedExtraction: the whole scene from the camera.
layout(location = 0) in vec3 position;  // metres, part frame, from the part's centre
layout(location = 1) in uint polygon;
layout(location = 2) in uint part;
#include "batched_common.glsl"
layout(location = 0) uniform mat4 clip_from_camera;
flat out vec4 v_plane;
flat out vec2 v_range;

void main() {
  gl_Position = clip_from_camera * (camera_from_part[part] * vec4(position, 1.0));
  v_plane = planes[polygon].inverse_z;
  v_range = planes[polygon].range.xy;
}
