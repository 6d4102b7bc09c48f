// Where charts lie at the levels from 4 to the tip, where each is a single texel. Level 4 lies in pages, the others each
// in a texture of one layer.
#include "batched_charts.glsl"
layout(std430, binding = 8) readonly buffer TipRects { ivec4 tip_rects[]; };  // by level - 4, then chart: x, y, w, h
layout(std430, binding = 6) readonly buffer ChartList { uint chart_list[]; };

ivec4 tip_rect(int level, uint chart) { return tip_rects[(level - 4) * charts.length() + int(chart)]; }
