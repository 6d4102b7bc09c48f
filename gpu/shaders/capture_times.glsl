// When what a chart shows was captured: TextureStore::capture_times().
layout(binding = 3) uniform isampler2DArray capture_times;

const int kNeverCaptured = -0x7fffffff - 1;

// Of the texel `texel` of a page: milliseconds since TextureStore::epoch(), or kNeverCaptured.
int capture_time(vec2 texel, int page) { return texelFetch(capture_times, ivec3(ivec2(texel) >> 4, page), 0).r; }
