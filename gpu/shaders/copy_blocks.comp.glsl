#version 450 core
// Copies blocks of 16 x 16 texels, and what lies over them in levels 1..4, from one set of pages to another. Texels
// are moved as they are: RGBA8 seen as R32UI. One workgroup per block.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform usampler2DArray pages;
layout(binding = 0, r32ui) writeonly uniform uimage2DArray level0;
layout(binding = 1, r32ui) writeonly uniform uimage2DArray level1;
layout(binding = 2, r32ui) writeonly uniform uimage2DArray level2;
layout(binding = 3, r32ui) writeonly uniform uimage2DArray level3;
layout(binding = 4, r32ui) writeonly uniform uimage2DArray level4;
#include "chart_blocks.glsl"

void main() {
  ivec2 block;
  int page;
  if (!find_block(block, page)) return;
  ivec2 cell = ivec2(gl_LocalInvocationID.xy);

  for (int y = 0; y < 16; y += 8) {
    for (int x = 0; x < 16; x += 8) {
      ivec3 at = ivec3(block * 16 + cell + ivec2(x, y), page);
      imageStore(level0, at, texelFetch(pages, at, 0));
    }
  }
  ivec3 at1 = ivec3(block * 8 + cell, page);
  imageStore(level1, at1, texelFetch(pages, at1, 1));
  if (any(greaterThan(cell, ivec2(3)))) return;
  ivec3 at2 = ivec3(block * 4 + cell, page);
  imageStore(level2, at2, texelFetch(pages, at2, 2));
  if (any(greaterThan(cell, ivec2(1)))) return;
  ivec3 at3 = ivec3(block * 2 + cell, page);
  imageStore(level3, at3, texelFetch(pages, at3, 3));
  if (any(greaterThan(cell, ivec2(0)))) return;
  ivec3 at4 = ivec3(block, page);
  imageStore(level4, at4, texelFetch(pages, at4, 4));
}
