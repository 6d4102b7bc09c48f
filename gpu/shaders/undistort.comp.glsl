#version 450 core
// A lens's picture to the picture of the same camera without distortion; alpha 1 where it is usable. The lens models
// are those of CameraModel::distort.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D lens_picture;
layout(rgba8, binding = 0) writeonly uniform image2D undistorted;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform vec2 focal_length;     // pixels
layout(location = 2) uniform vec2 principal_point;  // pixels
layout(location = 3) uniform bool fisheye;
layout(location = 4) uniform float k[8];
layout(location = 12) uniform ivec2 row_range;  // the first, and the one after the last

vec2 distort(vec2 p) {
  float r2 = dot(p, p);
  if (fisheye) {
    float r = sqrt(r2);
    if (r < 1e-6) return p;
    float theta = atan(r), t2 = theta * theta;
    return p * (theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r);
  }
  float radial = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
  return p * radial + vec2(2.0 * k[2] * p.x * p.y + k[3] * (r2 + 2.0 * p.x * p.x),
                           k[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * k[3] * p.x * p.y);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, row_range.x);
  if (any(greaterThanEqual(pixel, ivec2(size.x, row_range.y)))) return;
  vec2 straight = (vec2(pixel) + 0.5 - principal_point) / focal_length;
  vec2 position = distort(straight) * focal_length + principal_point - 0.5;
  vec4 result = vec4(0.0);
  // Written so that a position that is no number is outside.
  if (all(greaterThanEqual(position, vec2(0.0))) && all(lessThan(position, vec2(size - 1)))) {
    ivec2 p = ivec2(position);
    vec2 f = position - vec2(p);
    result = vec4(mix(mix(texelFetch(lens_picture, p, 0).rgb, texelFetch(lens_picture, p + ivec2(1, 0), 0).rgb, f.x),
                      mix(texelFetch(lens_picture, p + ivec2(0, 1), 0).rgb,
                          texelFetch(lens_picture, p + ivec2(1, 1), 0).rgb, f.x),
                      f.y),
                  1.0);
  }
  imageStore(undistorted, pixel, result);
}
