#pragma once
#include <map>
#include <string>

#include "foreview/recordings/recording.h"

namespace foreview {

/// Counts damaged items while a recording is read and remembers the first place of each kind, so that a thousand bad
/// lines make one line of log.
class DamageLog {
 public:
  using Kind = std::size_t RecordingDamage::*;

  void note(Kind kind, const std::string& where, const std::string& why);
  /// One warning per kind that occurred, naming `recording`.
  void report(const std::string& recording) const;
  [[nodiscard]] const RecordingDamage& counts() const { return counts_; }
  /// "12 lines malformed, first rgb.txt:3: ..." of all kinds, for the error of a recording with nothing usable left;
  /// empty where nothing was wrong.
  [[nodiscard]] std::string summary() const;

 private:
  RecordingDamage counts_;
  std::map<std::size_t, std::string> first_;  ///< by place in the table of kinds
};

}  // namespace foreview
