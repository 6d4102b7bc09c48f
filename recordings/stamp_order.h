#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "foreview/recordings/damage_log.h"

namespace foreview {

/// Puts samples (with a `stamp` and the `line` they come from) in order of time and keeps the first of equal stamps;
/// notes both kinds of damage. Stable, so the result does not depend on anything but the file.
template <typename Sample>
void sort_by_stamp(std::vector<Sample>& samples, const std::string& file, DamageLog& damage) {
  const auto note = [&](DamageLog::Kind kind, const Sample& sample, const char* why) {
    damage.note(kind, file + ":" + std::to_string(sample.line), sample.stamp.to_string() + why);
  };
  bool sorted = true;
  for (std::size_t i = 1, latest = 0; i < samples.size(); ++i) {
    if (samples[i].stamp < samples[latest].stamp) {
      note(&RecordingDamage::stamps_out_of_order, samples[i], " is earlier than a line before");
      sorted = false;
    } else {
      latest = i;
    }
  }
  if (!sorted) {
    std::stable_sort(samples.begin(), samples.end(),
                     [](const Sample& a, const Sample& b) { return a.stamp < b.stamp; });
  }
  const auto last = std::unique(samples.begin(), samples.end(), [&](const Sample& a, const Sample& b) {
    if (a.stamp != b.stamp) return false;
    note(&RecordingDamage::stamps_duplicated, b, " is there already");
    return true;
  });
  samples.erase(last, samples.end());
}

}  // namespace foreview
