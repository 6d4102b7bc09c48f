// The charts; the same struct as in gpu/batched/chart_tables.h.

struct ChartBlock {
  ivec4 block;  // texels in the page: x, y, width, height
  ivec4 place;  // page; first patch; patches; unused
};
layout(std430, binding = 7) readonly buffer Charts { ChartBlock charts[]; };
