#include "foreview/viewer/pacing.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include "foreview/gpu/gl_objects.h"
#include "foreview/viewer/bench_statistics.h"

namespace foreview {
namespace {

double milliseconds(Duration duration) {
  return 1e-6 * static_cast<double>(duration.nanoseconds);
}

/// Frames completed in the second that has fewest of them, from the first to the last.
double least_in_a_second(const std::vector<FrameRecord>& frames) {
  constexpr Duration kSecond{1'000'000'000};
  if (frames.size() < 2 || frames.back().completed - frames.front().completed < kSecond) return 0;
  std::size_t least = frames.size(), end = 0;
  for (std::size_t begin = 0; begin < frames.size(); ++begin) {
    const Timestamp until = frames[begin].completed + kSecond;
    if (until > frames.back().completed) break;
    while (end < frames.size() && frames[end].completed <= until) ++end;
    least = std::min(least, end - begin - 1);
  }
  return static_cast<double>(least);
}

/// In half full blocks, so that dropping costs next to nothing each time.
template <class Record>
void add_kept(std::vector<Record>& records, const Record& record, std::size_t& dropped) {
  if (records.capacity() < 2 * PacingRun::kKept) records.reserve(2 * PacingRun::kKept);
  if (records.size() == 2 * PacingRun::kKept) {
    records.erase(records.begin(), records.begin() + PacingRun::kKept);
    dropped += PacingRun::kKept;
  }
  records.push_back(record);
}

double mean_completion(const PacingRun& run) {
  double sum = 0;
  for (const FrameRecord& frame : run.frames) sum += milliseconds(frame.completed - frame.due);
  return run.frames.empty() ? 0 : sum / static_cast<double>(run.frames.size());
}

}  // namespace

ResourceCounts count_resources() {
  ResourceCounts counts;
  counts.gl_objects = live_gl_objects();
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string name;
    std::size_t value = 0;
    words >> name >> value;
    if (name == "VmRSS:") counts.resident_bytes = value << 10;
    if (name == "Threads:") counts.threads = value;
  }
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    static_cast<void>(entry);
    ++counts.open_files;
  }
  return counts;
}

void PacingRun::add(const FrameRecord& frame) {
  frames_late += frame.completed > frame.due ? 1 : 0;
  add_kept(frames, frame, frames_dropped);
}

void PacingRun::add(const PictureRecord& picture) {
  add_kept(pictures, picture, pictures_dropped);
}

PacingSummary::Spread spread_of(std::vector<double> figures) {
  PacingSummary::Spread spread;
  if (figures.empty()) return spread;
  std::sort(figures.begin(), figures.end());
  spread.mean = std::accumulate(figures.begin(), figures.end(), 0.0) / static_cast<double>(figures.size());
  spread.least = figures.front();
  spread.median = quantile(figures, 0.5);
  spread.p95 = quantile(figures, 0.95);
  spread.p99 = quantile(figures, 0.99);
  spread.worst = figures.back();
  return spread;
}

PacingSummary summary_of(const PacingRun& run) {
  PacingSummary summary;
  const double seconds = (run.ended - run.started).seconds();
  std::vector<double> completions, intervals, drawing, pictures, displayed;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const FrameRecord& frame = run.frames[i];
    completions.push_back(milliseconds(frame.completed - frame.due));
    drawing.push_back(milliseconds(frame.completed - frame.started));
    if (i > 0) intervals.push_back(milliseconds(frame.completed - run.frames[i - 1].completed));
  }
  for (const PictureRecord& picture : run.pictures) {
    pictures.push_back(milliseconds(picture.finished - picture.begun));
    if (picture.displayed > Timestamp{}) displayed.push_back(milliseconds(picture.age_when_displayed));
  }
  summary.frames = run.frames.size() + run.frames_dropped;
  summary.late = run.frames_late;
  summary.skipped = run.schedule.skipped;
  summary.missed = run.schedule.missed;
  summary.slices = run.schedule.slices;
  summary.pictures = run.pictures.size() + run.pictures_dropped;
  if (seconds > 0) {
    summary.frames_per_second = static_cast<double>(summary.frames) / seconds;
    summary.pictures_per_second = static_cast<double>(summary.pictures) / seconds;
  }
  summary.worst_frames_per_second = least_in_a_second(run.frames);
  summary.completion = spread_of(std::move(completions));
  summary.interval = spread_of(std::move(intervals));
  summary.drawing = spread_of(std::move(drawing));
  summary.picture = spread_of(std::move(pictures));
  summary.displayed = spread_of(std::move(displayed));
  return summary;
}

double part_as_punctual(const PacingRun& run, const PacingRun& reference) {
  const double latest = mean_completion(reference) + 0.25 * milliseconds(run.period);
  const auto punctual = std::count_if(run.frames.begin(), run.frames.end(), [&](const FrameRecord& frame) {
    return milliseconds(frame.completed - frame.due) <= latest;
  });
  auto due = static_cast<std::int64_t>(run.frames.size()) + run.schedule.skipped + run.schedule.missed;
  if (run.frames_dropped > 0) {
    // Of those that are kept; what was skipped and missed among them shows as gaps.
    const Duration span = run.frames.back().due - run.frames.front().due;
    due = 1 + (span.nanoseconds + run.period.nanoseconds / 2) / run.period.nanoseconds;
  }
  return due > 0 ? static_cast<double>(punctual) / static_cast<double>(due) : 1.0;
}

}  // namespace foreview
