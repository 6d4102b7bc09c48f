#version 450 core
// Levels 1..4 of charts from level 0. Charts are aligned to blocks of 16 x 16 texels, so that one block makes exactly
// one texel of level 4 and no other chart has a part in it. One workgroup per block, one invocation per 4 x 4 texels.
layout(local_size_x = 4, local_size_y = 4) in;
layout(binding = 0) uniform sampler2DArray pages;
layout(binding = 0, rgba8) writeonly uniform image2DArray level1;
layout(binding = 1, rgba8) writeonly uniform image2DArray level2;
layout(binding = 2, rgba8) writeonly uniform image2DArray level3;
layout(binding = 3, rgba8) writeonly uniform image2DArray level4;
#include "chart_blocks.glsl"

shared vec4 means[4][4];

void main() {
  ivec2 block;
  int page;
  if (!find_block(block, page)) return;
  ivec2 cell = ivec2(gl_LocalInvocationID.xy);

  vec4 mean2 = vec4(0);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      ivec2 at1 = block * 8 + cell * 2 + ivec2(x, y);
      vec4 mean1 = 0.25 * (texelFetch(pages, ivec3(at1 * 2, page), 0) +
                           texelFetch(pages, ivec3(at1 * 2 + ivec2(1, 0), page), 0) +
                           texelFetch(pages, ivec3(at1 * 2 + ivec2(0, 1), page), 0) +
                           texelFetch(pages, ivec3(at1 * 2 + ivec2(1, 1), page), 0));
      imageStore(level1, ivec3(at1, page), mean1);
      mean2 += 0.25 * mean1;
    }
  }
  imageStore(level2, ivec3(block * 4 + cell, page), mean2);
  means[cell.y][cell.x] = mean2;
  memoryBarrierShared();
  barrier();
  if (any(greaterThan(cell, ivec2(1)))) return;
  ivec2 c = cell * 2;
  vec4 mean3 = 0.25 * (means[c.y][c.x] + means[c.y][c.x + 1] + means[c.y + 1][c.x] + means[c.y + 1][c.x + 1]);
  imageStore(level3, ivec3(block * 2 + cell, page), mean3);
  if (any(greaterThan(cell, ivec2(0)))) return;
  // In the same order as above, so that a uniform chart stays exactly uniform.
  vec4 mean4 = vec4(0);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      mean4 += 0.0625 * (means[2 * y][2 * x] + means[2 * y][2 * x + 1] + means[2 * y + 1][2 * x] +
                         means[2 * y + 1][2 * x + 1]);
    }
  }
  imageStore(level4, ivec3(block, page), mean4);
}
