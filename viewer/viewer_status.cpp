#include "foreview/viewer/viewer_status.h"

#include <unistd.h>

#include <cmath>
#include <fstream>

#include "foreview/viewer/formatted.h"

namespace foreview {

std::string time_text(Duration time) {
  const double seconds = std::abs(time.seconds());
  const char* sign = time.nanoseconds < 0 ? "-" : "";
  if (seconds < 60) return formatted("%s%.2f s", sign, seconds);
  // Of whole hundredths, so that 59.999 does not become 60.00.
  const auto hundredths = static_cast<long long>(std::llround(seconds * 100));
  return formatted("%s%lld:%05.2f", sign, hundredths / 6000, static_cast<double>(hundredths % 6000) / 100);
}

std::string age_text(Duration age) {
  const double seconds = age.seconds();
  if (seconds < 0.9995) return formatted("%.0f ms", seconds * 1e3);
  if (seconds < 9.995) return formatted("%.2f s", seconds);
  return formatted("%.0f s", seconds);
}

std::string bytes_text(std::size_t bytes) {
  const double mebibytes = static_cast<double>(bytes) / (1 << 20);
  return mebibytes < 1000 ? formatted("%.0f MiB", mebibytes) : formatted("%.1f GiB", mebibytes / 1024);
}

std::string bandwidth_text(double bits_per_second) {
  if (bits_per_second <= 0) return "no limit";
  if (bits_per_second < 999'500) return formatted("%.0f kbit/s", bits_per_second / 1e3);
  return formatted(bits_per_second < 9.95e6 ? "%.1f Mbit/s" : "%.0f Mbit/s", bits_per_second / 1e6);
}

std::string count_text(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

std::string viewer_title(const TitleInput& input) {
  if (input.live) {
    return "foreview: " + input.name + " | " + to_string(input.mode) + " | live | " +
           (input.age ? age_text(*input.age) + " old" : std::string("no picture yet")) +
           formatted(" | %.0f fps", input.rate);
  }
  std::string title = "foreview: " + input.name +
                      formatted(" | %s | %.2f s | delay %.0f ms | %.0f fps", to_string(input.mode),
                                input.since_first.seconds(), input.delay.seconds() * 1e3, input.rate);
  if (input.at_end) {
    title += " | end";
  } else if (input.paused) {
    title += " | paused";
  }
  if (input.extracting && (input.paused || input.at_end)) title += " | extracting";
  return title;
}

double plot_top(double greatest) {
  double decade = 1;
  while (decade * 10 < greatest) decade *= 10;
  for (const double step : {1.0, 2.0, 5.0, 10.0}) {
    if (decade * step >= greatest) return decade * step;
  }
  return decade * 10;
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  if (!(file >> total >> resident)) return 0;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace foreview
