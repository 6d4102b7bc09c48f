#version 450 core
layout(location = 0) in vec3 corner_in_camera;
layout(location = 1) in uint corner_polygon;
layout(location = 0) uniform mat4 clip_from_camera;
flat out uint polygon;

void main() {
  polygon = corner_polygon;
  gl_Position = clip_from_camera * vec4(corner_in_camera, 1.0);
}
