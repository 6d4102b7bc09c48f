// What rule 5 counts; the same sizes as in gpu/batched/exposure_estimator.h.
const uint kBins = 128u;      // per channel
const float kReach = 0.32;    // bins span logarithms of -kReach to kReach against the last gain
layout(std430, binding = 11) buffer Counts {
  uint weights[3u * kBins];    // red, green, blue
  int differences[3u * kBins];
  uint samples_taken;
};
layout(std430, binding = 12) buffer Gains {
  vec4 shown_gain;
  vec4 inverse_gain;
};
