#pragma once
#include <cstdio>
#include <string>

namespace foreview {

/// What std::printf() would print, as a string: for one line of a panel or a report, cut off after 255 characters.
template <class... Values>
[[nodiscard]] std::string formatted(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

}  // namespace foreview
