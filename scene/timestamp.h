#pragma once
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace foreview {

/// A difference of two times, in whole nanoseconds.
struct Duration {
  std::int64_t nanoseconds = 0;

  constexpr auto operator<=>(const Duration&) const = default;  // NOLINT(modernize-use-nullptr): the compiler's own 0
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(nanoseconds) * 1e-9; }
  /// Rounds to the nearest nanosecond.
  [[nodiscard]] static Duration from_seconds(double seconds);
  /// Reads "500ms", "0.5s", "2 s", "40us", "5min", "1h" or a plain number of seconds. Throws InputError naming `what`.
  [[nodiscard]] static Duration parse(std::string_view text, const std::string& what);
};

/// A moment: nanoseconds since an epoch that the recording or the sender chooses.
struct Timestamp {
  std::int64_t nanoseconds = 0;

  constexpr auto operator<=>(const Timestamp&) const = default;  // NOLINT(modernize-use-nullptr): the compiler's own 0
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(nanoseconds) * 1e-9; }
  [[nodiscard]] static Timestamp from_seconds(double seconds);
  /// Reads decimal seconds without the loss that a double has at today's Unix times ("1700000000.123456789").
  /// Returns false, and leaves `result` alone, unless all of `text` is a number in range.
  [[nodiscard]] static bool parse_seconds(std::string_view text, Timestamp& result);
  /// Decimal seconds with nine digits; parse_seconds reads them back exactly.
  [[nodiscard]] std::string to_string() const;
};

constexpr Timestamp operator+(Timestamp t, Duration d) {
  return {t.nanoseconds + d.nanoseconds};
}
constexpr Timestamp operator-(Timestamp t, Duration d) {
  return {t.nanoseconds - d.nanoseconds};
}
constexpr Duration operator-(Timestamp a, Timestamp b) {
  return {a.nanoseconds - b.nanoseconds};
}
constexpr Duration operator+(Duration a, Duration b) {
  return {a.nanoseconds + b.nanoseconds};
}

}  // namespace foreview
