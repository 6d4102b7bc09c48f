// Rules 4 and 5: whether a cell (batched_cells.frag.glsl) has a colour for a surface. `slack` and `thin` are its
// polygon's (Plane::range.z, Plane::inverse_z.w).
bool may_take(vec2 limits, float w, float slack, bool thin) {
  // Negative: only thin polygons may take anything there.
  float greatest = thin ? abs(limits.y) : limits.y;
  return limits.x <= greatest && w + slack >= limits.x && w - slack <= greatest;
}
