#version 450 core
// Rule 5: the picture's gain from what was counted, which is forgotten.
layout(local_size_x = 128) in;
#include "batched_exposure.glsl"
layout(location = 0) uniform uint least_samples;
layout(location = 1) uniform bool is_late;  // a newer picture decides what is shown

const int kWindow = 28;  // bins on either side of the median that count: a factor of exp(0.14)
const float kGreatest = 3.0;

shared uint own_weights[3u * kBins];
shared int own_differences[3u * kBins];

void main() {
  for (uint i = gl_LocalInvocationID.x; i < 3u * kBins; i += gl_WorkGroupSize.x) {
    own_weights[i] = weights[i];
    own_differences[i] = differences[i];
    weights[i] = 0u;
    differences[i] = 0;
  }
  uint taken = samples_taken;
  barrier();
  uint channel = gl_LocalInvocationID.x;
  if (channel == 0u) samples_taken = 0u;
  if (channel >= 3u) return;
  float gain = shown_gain[channel];
  if (taken >= least_samples) {
    uint first = channel * kBins, total = 0u, below = 0u, median = 0u;
    for (uint i = 0u; i < kBins; ++i) total += own_weights[first + i];
    while (below + own_weights[first + median] < (total + 1u) / 2u) below += own_weights[first + median++];
    uint from = uint(max(int(median) - kWindow, 0)), to = min(median + uint(kWindow), kBins - 1u);
    uint weight = 0u;
    int difference = 0;
    for (uint i = from; i <= to; ++i) {
      weight += own_weights[first + i];
      difference += own_differences[first + i];
    }
    gain = clamp(gain * exp(float(difference) / float(max(weight, 1u))), 1.0 / kGreatest, kGreatest);
  }
  inverse_gain[channel] = 1.0 / gain;
  if (!is_late) shown_gain[channel] = gain;
}
