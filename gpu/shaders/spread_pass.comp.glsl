#version 450 core
// Pass k = pass_index >= 1 colours the polygons that touch one coloured before it. A neighbour that this very pass
// colours has rim k and is not read, so the result does not depend on the order of invocations. The next pass has work only where this one coloured something.
#include "spread_common.glsl"

void main() {
  uint polygon = gl_GlobalInvocationID.x;
  if (polygon >= polygon_count) return;
  if (rims[polygon] != NOT_YET) return;
  vec3 sum = vec3(0);
  float count = 0.0;
  for (uint i = first_neighbour[polygon]; i < first_neighbour[polygon + 1u]; ++i) {
    uint neighbour = neighbours[i];
    if (rims[neighbour] >= pass_index) continue;
    sum += states[neighbour].rgb;
    count += 1.0;
  }
  if (count == 0.0) return;
  states[polygon] = vec4(sum / count, 0.5);
  rims[polygon] = pass_index;
  commands[3u * next_command] = gl_NumWorkGroups.x;
}
