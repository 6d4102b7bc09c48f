// The squares that charts are cut into, and the lists of them that a picture concerns; the same structs as in
// gpu/batched/chart_tables.h.

struct Patch {
  vec4 ball;    // around its polygons: metres, part frame from the part's centre; radius, negative: no polygon in it
  ivec4 rect;   // texels in the page: x, y, width, height
  ivec4 place;  // page; chart; part; patches of its chart side by side
  vec4 extent;  // texels that can ever be observed, by area; unused
};
struct DrawCommand {
  uint count, instances, first, base;
};
layout(std430, binding = 2) readonly buffer Patches { Patch patches[]; };
// Number of the last picture that touched it, 0: none; kFirstTime: none before that one.
layout(std430, binding = 3) buffer PatchFlags { uint patch_flags[]; };
layout(std430, binding = 4) buffer Commands {
  DrawCommand commands[3];
  uint touched_groups;  // of kPatchesPerGroup touched patches: x of a dispatch
};
layout(std430, binding = 5) buffer Lists { uint listed_patches[]; };

const uint kFirstTime = 0x80000000u;

bool is_touched(uint index, uint picture_number) { return (patch_flags[index] & ~kFirstTime) == picture_number; }

const uint kPatchesPerGroup = 16u;
const uint kTouched = 0u;  // lists, by place: texels may have changed
const uint kRenewed = 1u;  // levels 1..3 must be made anew
const uint kHoled = 2u;    // and level 0's holes
const int kCoarse = 8;     // pixels along the side of a cell of the coarse bounds
