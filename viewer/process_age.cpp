#include "foreview/viewer/process_age.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace foreview {

Duration process_age() {
  std::ifstream file("/proc/self/stat");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  // proc(5): the second field is the program's name in brackets, which may hold anything; the 22nd is when it started.
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return {};
  std::istringstream rest(text.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 22; ++field) rest >> skipped;
  std::int64_t ticks = 0;
  const std::int64_t ticks_per_second = sysconf(_SC_CLK_TCK);
  timespec now{};
  if (!(rest >> ticks) || ticks_per_second <= 0 || clock_gettime(CLOCK_BOOTTIME, &now) != 0) return {};
  const std::int64_t since_boot = std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
  return {std::max<std::int64_t>(since_boot - ticks * (1'000'000'000 / ticks_per_second), 0)};
}

}  // namespace foreview
