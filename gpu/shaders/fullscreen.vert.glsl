#version 450 core
// One triangle that covers the viewport: glDrawArrays(GL_TRIANGLES, 0, 3) with any vertex array bound.
// v_uv runs from (0, 0) at the viewport's first row and column to (1, 1).
out vec2 v_uv;

void main() {
  v_uv = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(v_uv * 2.0 - 1.0, 0.0, 1.0);
}
