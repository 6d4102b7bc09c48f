// Buffers of spread_begin, spread_pass and spread_end.
layout(local_size_x = 64) in;
// Mean colour; w: 1 seen, 0.5 coloured by its neighbours, 0 neither.
layout(binding = 0, std430) buffer States { vec4 states[]; };
layout(binding = 1, std430) readonly buffer FirstNeighbour { uint first_neighbour[]; };  // polygons + 1
layout(binding = 2, std430) readonly buffer Neighbours { uint neighbours[]; };
// The pass after which a polygon's colour may be used; NOT_YET: it has none.
layout(binding = 3, std430) buffer Rims { uint rims[]; };
// Dispatch commands, x, y, z each: of a round's passes and of the pass behind them.
layout(binding = 4, std430) buffer Commands { uint commands[]; };
layout(location = 0) uniform uint polygon_count;
layout(location = 1) uniform uint pass_index;
layout(location = 2) uniform uint next_command;

const uint NOT_YET = 0xffffffffu;
