#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "foreview/scene/timestamp.h"

namespace foreview {

/// Lines longer than this are taken for binary data.
inline constexpr std::size_t kLongestLine = 4096;

/// Stamps of recordings lie within this many seconds of zero, so that the difference of any two fits in 64 bits.
inline constexpr std::int64_t kLargestStampSeconds = 4'000'000'000;

[[nodiscard]] inline bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

[[nodiscard]] inline std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && (is_blank(text.back()) || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

/// Calls take(number, line), numbers from 1, for every line that is neither blank nor a `#` comment, trimmed; CRLF and
/// a byte-order mark at the beginning are accepted.
template <typename Take>
void for_each_line(std::string_view text, const Take& take) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.front() != '#') take(number, line);
  }
}

/// Takes the first blank-separated word off `line`.
[[nodiscard]] inline std::string_view take_word(std::string_view& line) {
  line = trim(line);
  std::size_t end = 0;
  while (end < line.size() && !is_blank(line[end])) ++end;
  const std::string_view word = line.substr(0, end);
  line = trim(line.substr(end));
  return word;
}

/// A stamp in decimal seconds within kLargestStampSeconds.
[[nodiscard]] inline bool parse_stamp(std::string_view word, Timestamp& stamp) {
  Timestamp result;
  if (!Timestamp::parse_seconds(word, result)) return false;
  constexpr std::int64_t kLargest = kLargestStampSeconds * 1'000'000'000;
  if (result.nanoseconds < -kLargest || result.nanoseconds > kLargest) return false;
  stamp = result;
  return true;
}

}  // namespace foreview
