#include "foreview/recordings/damage_log.h"

#include <spdlog/spdlog.h>

#include <array>
#include <cstddef>

namespace foreview {
namespace {

struct KindName {
  DamageLog::Kind kind;
  const char* name;
};

constexpr std::array<KindName, 8> kKinds{{
    {&RecordingDamage::lines_malformed, "lines dropped, malformed"},
    {&RecordingDamage::stamps_out_of_order, "stamps out of order, sorted in"},
    {&RecordingDamage::stamps_duplicated, "lines dropped, their stamp was there already"},
    {&RecordingDamage::poses_not_finite, "poses dropped, not finite"},
    {&RecordingDamage::poses_not_unit, "poses dropped, quaternion not of unit length"},
    {&RecordingDamage::pictures_missing, "pictures dropped, file missing"},
    {&RecordingDamage::pictures_without_pose, "pictures dropped, no pose at their time"},
    {&RecordingDamage::pictures_unreadable, "pictures dropped, not readable"},
}};

std::string sentence(const RecordingDamage& counts, const KindName& kind, const std::string& first) {
  return std::to_string(counts.*kind.kind) + " " + kind.name + "; first " + first;
}

}  // namespace

std::size_t RecordingDamage::total() const {
  std::size_t sum = 0;
  for (const KindName& kind : kKinds) sum += this->*kind.kind;
  return sum;
}

void DamageLog::note(Kind kind, const std::string& where, const std::string& why) {
  if (counts_.*kind == 0) {
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
      if (kKinds[i].kind == kind) first_[i] = where + ": " + why;
    }
  }
  ++(counts_.*kind);
}

void DamageLog::report(const std::string& recording) const {
  for (const auto& [kind, first] : first_) spdlog::warn("{}: {}", recording, sentence(counts_, kKinds[kind], first));
}

std::string DamageLog::summary() const {
  std::string result;
  for (const auto& [kind, first] : first_) {
    result += (result.empty() ? "" : "; ") + sentence(counts_, kKinds[kind], first);
  }
  return result;
}

}  // namespace foreview
