#version 450 core
// Edges of polygons as lines over the predicted view or over a delayed picture.

layout(location = 0) in vec3 position;  // metres, part frame, from the part's centre
layout(location = 3) in uint part;

layout(std430, binding = 0) readonly buffer Parts { mat4 clip_from_part[]; };

// Edges lie in their polygons' planes: drawn this much nearer (relative to the distance) they win the depth test.
const float kNearer = 1.003;

void main() {
  gl_Position = clip_from_part[part] * vec4(position, 1.0);
  gl_Position.z *= kNearer;
}
