// Where the charts are, by polygon.
struct Chart {
  vec2 origin;  // texels, of the block in the page
  vec2 size;    // texels, of the block
  vec2 valid;   // texels: the polygon's box grown by the gutter, from the origin
  float page;
  float group;
};
layout(std430, binding = 1) readonly buffer Charts { Chart charts[]; };
