// What the CPU says about the polygons of one picture; the same structs as in gpu/per_polygon/picture_data.h.

// 1/z of a polygon's plane at a pixel: rising linearly from `inverse_z.z` at the pixel `reference`, and kept within
// what the polygon itself has, so that a plane seen edge-on cannot explode beyond its outline.
struct Plane {
  vec4 inverse_z;  // slopes along u and v, value at the reference, unused
  vec4 reference;  // u, v, least and greatest 1/z
};

struct PolygonInPicture {
  ivec4 box;            // pixels: x, y, width, height
  ivec4 texture_size;   // texels: width, height; polygon's index; unused
  uvec4 lists;          // first edge, edges, first neighbour, neighbours
  vec4 u_row;           // from (s, t, 1), s and t in 0..1 over the texture: (u - reference.u) z
  vec4 v_row;           // (v - reference.v) z
  vec4 z_row;           // z, metres
  vec4 reference;       // u, v in pixels
  ivec4 chart_block;    // in its page, texels: x, y, width, height
  vec4 texel_columns;   // texel of the texture = columns * (texel of the block) + offset
  vec4 texel_offset;
};

layout(std430, binding = 0) readonly buffer PolygonsInPicture { PolygonInPicture in_picture[]; };
layout(std430, binding = 1) readonly buffer Planes { Plane planes[]; };

const float kOutside = 31.0 / 32.0;  // alpha of what is not the polygon's, spec 5
const float kMidGrey = 128.0 / 255.0;

float inverse_z_at(Plane plane, vec2 pixel_from_reference) {
  return clamp(dot(plane.inverse_z.xy, pixel_from_reference) + plane.inverse_z.z, plane.reference.z,
               plane.reference.w);
}
