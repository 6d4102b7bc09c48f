#version 450 core
// Shapes and text over a frame: see viewer/frame_painter.h.

layout(location = 0) in vec2 position;  // pixels, row 0 of the framebuffer is y = 0
layout(location = 1) in vec2 place;
layout(location = 2) in vec4 colour;
layout(location = 3) in float kind;

layout(location = 0) uniform vec2 frame_size;  // pixels

out vec2 v_place;
flat out vec4 v_colour;
flat out float v_kind;

void main() {
  gl_Position = vec4(2.0 * position / frame_size - 1.0, 0.0, 1.0);
  v_place = place;
  v_colour = colour;
  v_kind = kind;
}
