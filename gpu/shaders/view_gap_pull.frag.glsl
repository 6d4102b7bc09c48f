#version 450 core
// Half the size: the means of what is below, by how much it is known.
layout(binding = 0) uniform sampler2D finer;        // bilinear; FIRST: the view
layout(binding = 1) uniform sampler2D finer_depth;  // bilinear; FIRST: the view's (reversed: goes as 1/z)
layout(location = 0) out vec4 pulled;               // colour times weight, weight
layout(location = 1) out vec2 pulled_depth;         // depth times weight, share that is known of polygons

#ifdef FIRST
#include "view_known.glsl"
// What lies behind gives a colour only where no polygon near by does; what is not known, where nothing is.
const float kWeightBehind = 1.0 / 1024.0, kWeightUnknown = 1e-6;
#endif

void main() {
  ivec2 first = 2 * ivec2(gl_FragCoord.xy);
#ifdef FIRST
  ivec2 last = textureSize(finer, 0) - 1;
  pulled = vec4(0.0);
  pulled_depth = vec2(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 at = min(first + ivec2(i & 1, i >> 1), last);
    vec4 texel = texelFetch(finer, at, 0);
    float polygon = is_polygon(texel.a) ? share_of_polygon(texel.a) : 0.0;
    float behind = is_behind(texel.a) ? share_behind(texel.a) : 0.0;
    // A pixel in which a polygon meets something else has the other's colour, too.
    float pure = max(4.0 * polygon - 3.0, 0.0);
    float weight = max(pure + kWeightBehind * behind, kWeightUnknown);
    pulled += 0.25 * vec4(texel.rgb * weight, weight);
    pulled_depth += 0.25 * vec2(texelFetch(finer_depth, at, 0).r * weight, polygon);
  }
#else
  // (1 3 3 1) / 8 along each axis, as four bilinear taps: a box would leave its corners in the fill.
  vec2 scale = 1.0 / vec2(textureSize(finer, 0));
  vec2 lower = (vec2(first) + 0.25) * scale, upper = (vec2(first) + 1.75) * scale;
  pulled = 0.25 * (textureLod(finer, lower, 0.0) + textureLod(finer, vec2(upper.x, lower.y), 0.0) +
                   textureLod(finer, vec2(lower.x, upper.y), 0.0) + textureLod(finer, upper, 0.0));
  pulled_depth =
      0.25 * (textureLod(finer_depth, lower, 0.0) + textureLod(finer_depth, vec2(upper.x, lower.y), 0.0) +
              textureLod(finer_depth, vec2(lower.x, upper.y), 0.0) + textureLod(finer_depth, upper, 0.0)).rg;
#endif
}
