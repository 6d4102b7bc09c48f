// The blocks of 16 x 16 texels that gpu/chart_blocks.h lists, one workgroup each.
// Bits 0-9 column, 10-19 row (in blocks), 20-31 page.
layout(binding = 0, std430) readonly buffer Blocks { uint blocks[]; };
layout(location = 0) uniform uint first_block;
layout(location = 1) uniform uint block_count;

// Column, row and page of this workgroup's block; false if there is none.
bool find_block(out ivec2 block, out int page) {
  uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  if (index >= block_count) return false;
  uint packed_block = blocks[first_block + index];
  block = ivec2(packed_block & 1023u, (packed_block >> 10) & 1023u);
  page = int(packed_block >> 20);
  return true;
}
