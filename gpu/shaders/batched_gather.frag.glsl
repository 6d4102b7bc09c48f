#version 450 core
// Rule 5. Without FOOTPRINT only for texels smaller than a pixel.
#include "exposure.glsl"
#include "batched_verdict.glsl"
layout(binding = 0) uniform sampler2D picture;  // bilinear
layout(binding = 1) uniform sampler2D bounds;
layout(location = 3) uniform float near_plane;  // metres
layout(location = 5) uniform ivec2 last_cell;
layout(location = 6) uniform vec2 pixel_to_uv;
noperspective in vec3 v_homogeneous;
flat in vec2 v_slack;
layout(location = 0) out vec4 colour;

bool is_safe(float w, vec2 pixel) {
  vec2 limits = texelFetch(bounds, clamp(ivec2(pixel - 0.5), ivec2(0), last_cell), 0).rg;
  return may_take(limits, w, v_slack.x, v_slack.y > 0.5);
}

void main() {
  float w = 1.0 / v_homogeneous.z;
  vec2 pixel = v_homogeneous.xy * w;
#ifdef FOOTPRINT
  // v_homogeneous is linear, so that these are exact.
  vec3 along_x = dFdx(v_homogeneous), along_y = dFdy(v_homogeneous);
  float step_x = length(along_x.xy - pixel * along_x.z) * w, step_y = length(along_y.xy - pixel * along_y.z) * w;
  vec2 cells = clamp(ceil(vec2(step_x, step_y) - 1e-3), 1.0, 4.0);
  vec3 sum = vec3(0.0);
  bool safe = true;
  for (float y = 0.5; y < cells.y; y += 1.0) {
    for (float x = 0.5; x < cells.x; x += 1.0) {
      vec3 h = v_homogeneous + along_x * (x / cells.x - 0.5) + along_y * (y / cells.y - 0.5);
      float own = 1.0 / h.z;
      vec2 at = h.xy * own;
      // The texel's centre is in the picture, but its samples need not be.
      safe = safe && h.z > near_plane && clamp(at, vec2(0.5), vec2(last_cell) + 1.5) == at && is_safe(own, at);
      sum += textureLod(picture, at * pixel_to_uv, 0.0).rgb;
    }
  }
  if (!safe) discard;
  colour = vec4(exposed(sum / (cells.x * cells.y), inverse_gain.rgb), 1.0);
#else
  if (!is_safe(w, pixel)) discard;
  colour = vec4(exposed(textureLod(picture, pixel * pixel_to_uv, 0.0).rgb, inverse_gain.rgb), 1.0);
#endif
}
