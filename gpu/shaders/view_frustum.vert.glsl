#version 450 core
// A camera's frustum as lines: from its centre to the corners of a far rectangle, and the rectangle's sides; and the
// picture's plane near the camera.

uniform vec4 clip_corners[9];  // centre, near rectangle, far rectangle

const int kEnds[24] = int[24](0, 5, 0, 6, 0, 7, 0, 8, 5, 6, 6, 7, 7, 8, 8, 5, 1, 2, 2, 3, 3, 4, 4, 1);

void main() { gl_Position = clip_corners[kEnds[gl_VertexID]]; }
