#include "foreview/scene/timestamp.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

std::int64_t nanoseconds_from(double seconds) {
  // 9.2e9 seconds are the 292 years that int64 nanoseconds span; llround of more is undefined.
  if (!(std::abs(seconds) < 9.2e9)) throw InputError("time", "outside the 292 years that nanoseconds can count");
  return std::llround(seconds * 1e9);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

}  // namespace

Duration Duration::from_seconds(double seconds) {
  return {nanoseconds_from(seconds)};
}
Timestamp Timestamp::from_seconds(double seconds) {
  return {nanoseconds_from(seconds)};
}

Duration Duration::parse(std::string_view text, const std::string& what) {
  const std::string_view all = trimmed(text);
  double number = 0;
  const auto [end, error] = std::from_chars(all.data(), all.data() + all.size(), number);
  const std::string_view unit = trimmed(all.substr(static_cast<std::size_t>(end - all.data())));
  double scale = 0;
  if (unit.empty() || unit == "s") scale = 1;
  if (unit == "ms") scale = 1e-3;
  if (unit == "us") scale = 1e-6;
  if (unit == "min") scale = 60;
  if (unit == "h") scale = 3600;
  if (error != std::errc() || scale == 0 || !(std::abs(number * scale) < 9.2e9)) {
    throw InputError(what,
                     "'" + std::string(text) + "' is no duration; expected a number with a unit, as in 500ms or 0.5s");
  }
  return from_seconds(number * scale);
}

bool Timestamp::parse_seconds(std::string_view text, Timestamp& result) {
  text = trimmed(text);
  bool negative = false;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  std::int64_t whole = 0;
  const char* const stop = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), stop, whole);
  if (error != std::errc() || whole < 0 || whole > 9'000'000'000) {
    // Exponents and a bare leading point are rare: a double is precise enough for them.
    return false;
  }
  std::int64_t fraction = 0;
  const char* p = end;
  if (p != stop && *p == '.') {
    ++p;
    std::int64_t unit = 100'000'000;
    for (; p != stop && *p >= '0' && *p <= '9'; ++p) {
      fraction += unit * (*p - '0');
      unit /= 10;
    }
  }
  if (p != stop) {
    double value = 0;
    const auto [whole_end, whole_error] = std::from_chars(text.data(), stop, value);
    if (whole_error != std::errc() || whole_end != stop || !(std::abs(value) < 9e9)) return false;
    result.nanoseconds = std::llround(value * 1e9) * (negative ? -1 : 1);
    return true;
  }
  result.nanoseconds = (whole * 1'000'000'000 + fraction) * (negative ? -1 : 1);
  return true;
}

std::string Timestamp::to_string() const {
  char text[40];
  const std::uint64_t magnitude =
      nanoseconds < 0 ? ~static_cast<std::uint64_t>(nanoseconds) + 1 : static_cast<std::uint64_t>(nanoseconds);
  std::snprintf(text, sizeof text, "%s%llu.%09llu", nanoseconds < 0 ? "-" : "",
                static_cast<unsigned long long>(magnitude / 1'000'000'000),
                static_cast<unsigned long long>(magnitude % 1'000'000'000));
  return text;
}

}  // namespace foreview
