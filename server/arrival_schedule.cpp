#include "foreview/server/arrival_schedule.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <tuple>

namespace foreview {

std::vector<SentPicture> pictures_of(const Recording& recording) {
  std::vector<SentPicture> pictures;
  for (std::size_t camera = 0; camera < recording.cameras().size(); ++camera) {
    const auto& entries = recording.cameras()[camera].pictures;
    for (std::size_t index = 0; index < entries.size(); ++index) {
      std::error_code error;
      const auto bytes = std::filesystem::file_size(entries[index].file, error);
      pictures.push_back({camera, index, entries[index].stamp, error ? 0 : static_cast<std::size_t>(bytes)});
    }
  }
  std::sort(pictures.begin(), pictures.end(), [](const SentPicture& a, const SentPicture& b) {
    return std::tie(a.capture, a.camera, a.index) < std::tie(b.capture, b.camera, b.index);
  });
  return pictures;
}

ArrivalSchedule schedule_arrivals(const std::vector<SentPicture>& pictures, const LinkOptions& options) {
  ArrivalSchedule schedule;
  SimulatedLink link(options);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (const auto arrival = link.send(pictures[i].capture, pictures[i].bytes)) {
      schedule.arrivals.push_back({*arrival, i});
    } else {
      schedule.losses.push_back({pictures[i].capture + options.delay, i});
    }
  }
  std::stable_sort(schedule.arrivals.begin(), schedule.arrivals.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return schedule;
}

}  // namespace foreview
