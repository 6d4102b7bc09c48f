#version 450 core
// A picture over the whole viewport, row 0 of the texture in row 0 of the framebuffer.

layout(binding = 0) uniform sampler2D picture;

in vec2 v_uv;
layout(location = 0) out vec4 colour;

void main() { colour = vec4(texture(picture, v_uv).rgb, 1.0); }
