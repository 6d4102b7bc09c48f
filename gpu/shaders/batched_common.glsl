// What the CPU says of one picture; the same structs as in gpu/batched/picture_setup.h.

struct Plane {
  vec4 inverse_z;  // 1/z at a pixel: slopes along u and v (1/m per pixel), value at the principal point, 1 if thin
  vec4 range;      // least and greatest 1/z of the polygon itself, rule 5's s, 1 if its front is seen, else 0
};
layout(std430, binding = 0) readonly buffer Parts { mat4 camera_from_part[]; };
layout(std430, binding = 1) readonly buffer Planes { Plane planes[]; };
