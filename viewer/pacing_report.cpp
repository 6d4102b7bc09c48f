#include "foreview/viewer/pacing_report.h"

#include <nlohmann/json.hpp>

#include "foreview/viewer/formatted.h"
#include "foreview/viewer/registration_report.h"

namespace foreview {
namespace {

using Json = nlohmann::ordered_json;

const PacingRun* find(const PacingReport& report, bool frames, bool pictures) {
  for (const PacingRun& run : report.runs) {
    if ((run.period > Duration{}) == frames && run.pictures.empty() != pictures) return &run;
  }
  return nullptr;
}

std::string spread_text(const char* what, const PacingSummary::Spread& spread) {
  return formatted("  %-34s mean %8.2f   median %8.2f   p95 %8.2f   p99 %8.2f   worst %8.2f ms\n", what, spread.mean,
                   spread.median, spread.p95, spread.p99, spread.worst);
}

std::string run_text(const PacingRun& run) {
  const PacingSummary summary = summary_of(run);
  std::string text = run.name + formatted(", %.1f s\n", (run.ended - run.started).seconds());
  if (summary.frames > 0) {
    text += formatted(
        "  frames: %zu, %.2f a second (worst second %.0f; wanted %.2f), late %zu, skipped %lld, missed %lld\n",
        summary.frames, summary.frames_per_second, summary.worst_frames_per_second, 1 / run.period.seconds(),
        summary.late, static_cast<long long>(summary.skipped), static_cast<long long>(summary.missed));
    text += spread_text("complete after the due time", summary.completion);
    text += spread_text("drawing", summary.drawing);
  }
  if (summary.pictures > 0) {
    text += formatted("  pictures: %zu, %.2f a second, %lld slices\n", summary.pictures, summary.pictures_per_second,
                      static_cast<long long>(summary.slices));
    text += spread_text("extracting a picture", summary.picture);
    if (summary.displayed.worst > 0) text += spread_text("displayed after capture", summary.displayed);
  }
  if (run.frames_dropped > 0) text += formatted("  of the last %zu frames only:\n", run.frames.size());
  for (const PacingRun::Kind& kind : run.slices) {
    if (kind.slices == 0) continue;
    text += formatted("  slices %-20s %7zu, mean %6.2f ms, worst %6.2f ms, %zu over %.1f ms\n", kind.name.c_str(),
                      kind.slices, kind.total_ms / static_cast<double>(kind.slices), kind.worst_ms, kind.over_bound,
                      run.slice_bound_ms);
  }
  if (run.intervals.size() > 1) {
    text += pacing_interval_heading();
    for (const PacingRun::Interval& interval : run.intervals) text += pacing_text(interval);
  }
  return text;
}

Json spread_json(const PacingSummary::Spread& spread) {
  return {{"mean", spread.mean}, {"least", spread.least}, {"median", spread.median},
          {"p95", spread.p95},   {"p99", spread.p99},     {"worst", spread.worst}};
}

Json run_json(const PacingRun& run) {
  const PacingSummary summary = summary_of(run);
  const auto ms = [&](Timestamp when) { return 1e-6 * static_cast<double>((when - run.started).nanoseconds); };
  Json slices = Json::array(), frames = Json::array(), pictures = Json::array();
  for (const PacingRun::Kind& kind : run.slices) {
    slices.push_back({{"kind", kind.name},
                      {"slices", kind.slices},
                      {"total_ms", kind.total_ms},
                      {"worst_ms", kind.worst_ms},
                      {"over_bound", kind.over_bound}});
  }
  for (const FrameRecord& frame : run.frames) {
    frames.push_back({{"due_ms", ms(frame.due)},
                      {"start_ms", ms(frame.started)},
                      {"completion_ms", ms(frame.completed)},
                      {"picture", frame.picture}});
  }
  for (const PictureRecord& picture : run.pictures) {
    Json json{{"camera", picture.camera},
              {"index", picture.index},
              {"number", picture.picture},
              {"begun_ms", ms(picture.begun)},
              {"finished_ms", ms(picture.finished)},
              {"displayed_ms", nullptr},
              {"displayed_after_capture_ms", nullptr},
              {"slices", picture.slices},
              {"frames_meanwhile", picture.frames_meanwhile}};
    if (picture.displayed > Timestamp{}) {
      json["displayed_ms"] = ms(picture.displayed);
      json["displayed_after_capture_ms"] = 1e-6 * static_cast<double>(picture.age_when_displayed.nanoseconds);
    }
    pictures.push_back(std::move(json));
  }
  Json json{{"name", run.name},
            {"seconds", (run.ended - run.started).seconds()},
            {"rate_wanted", run.period > Duration{} ? Json(1 / run.period.seconds()) : Json(nullptr)},
            {"rate_reached", summary.frames_per_second},
            {"rate_worst_second", summary.worst_frames_per_second},
            {"frames_drawn", summary.frames},
            {"frames_late", summary.late},
            {"frames_skipped", summary.skipped},
            {"frames_missed", summary.missed},
            {"completion_after_due_ms", spread_json(summary.completion)},
            {"drawing_ms", spread_json(summary.drawing)},
            {"interval_ms", spread_json(summary.interval)},
            {"slices", summary.slices},
            {"slices_oversize", run.schedule.oversize_slices},
            {"slices_by_kind", std::move(slices)},
            {"pictures_extracted", summary.pictures},
            {"pictures_per_second", summary.pictures_per_second},
            {"picture_ms", spread_json(summary.picture)},
            {"displayed_after_capture_ms", spread_json(summary.displayed)}};
  json["restarts"] = run.restarts;
  Json intervals = Json::array();
  for (const PacingRun::Interval& interval : run.intervals) {
    intervals.push_back({{"seconds", interval.seconds},
                         {"frames_drawn", interval.frames},
                         {"frames_late", interval.late},
                         {"frames_skipped", interval.skipped},
                         {"frames_missed", interval.missed},
                         {"completion_after_due_ms",
                          {{"median", interval.median_ms}, {"p99", interval.p99_ms}, {"worst", interval.worst_ms}}},
                         {"pictures", interval.pictures},
                         {"resident_bytes", interval.resources.resident_bytes},
                         {"open_files", interval.resources.open_files},
                         {"threads", interval.resources.threads},
                         {"gl_objects", interval.resources.gl_objects}});
  }
  json["intervals"] = std::move(intervals);
  json["frames_dropped"] = run.frames_dropped;
  json["pictures_dropped"] = run.pictures_dropped;
  json["frames"] = std::move(frames);
  json["pictures"] = std::move(pictures);
  return json;
}

}  // namespace

std::string pacing_interval_heading() {
  return "  seconds   frames  late  skipped  missed  median     p99   worst ms  pictures   MiB  files  GL objects\n";
}

std::string pacing_text(const PacingRun::Interval& interval) {
  return formatted("  %7.0f %8zu %5lld %8lld %7lld %7.2f %7.2f %7.2f    %8zu %5zu %6zu %11ld\n", interval.seconds,
                   interval.frames, static_cast<long long>(interval.late), static_cast<long long>(interval.skipped),
                   static_cast<long long>(interval.missed), interval.median_ms, interval.p99_ms, interval.worst_ms,
                   interval.pictures, interval.resources.resident_bytes >> 20, interval.resources.open_files,
                   interval.resources.gl_objects);
}

std::string pacing_text(const PacingReport& report) {
  std::string text =
      formatted("frames of %d x %d, quality %s%s, on %s\n", report.width, report.height, report.quality.c_str(),
                report.realtime ? ", in real time" : "", report.renderer.c_str());
  for (const PacingRun& run : report.runs) text += run_text(run);
  text += "registration: " + to_text(report.registration) + "\n";
  const PacingRun* both = find(report, true, true);
  const PacingRun* display = find(report, true, false);
  const PacingRun* extraction = find(report, false, true);
  if (both != nullptr && display != nullptr) {
    text += formatted("%.2f %% of the frames complete within a quarter period of when they do without extraction\n",
                      100 * part_as_punctual(*both, *display));
  }
  if (both != nullptr && extraction != nullptr) {
    text += formatted("%.0f %% of the picture rate that extraction reaches alone\n",
                      100 * summary_of(*both).pictures_per_second / summary_of(*extraction).pictures_per_second);
  }
  return text;
}

std::string pacing_json(const PacingReport& report) {
  Json runs = Json::array();
  for (const PacingRun& run : report.runs) runs.push_back(run_json(run));
  Json json{{"format", "foreview-pacing"}, {"version", kPacingJsonVersion}, {"recording", report.recording},
            {"renderer", report.renderer}, {"width", report.width},         {"height", report.height},
            {"quality", report.quality},   {"realtime", report.realtime},   {"delay_seconds", report.delay_seconds},
            {"runs", std::move(runs)}};
  const PacingRun* both = find(report, true, true);
  const PacingRun* display = find(report, true, false);
  const PacingRun* extraction = find(report, false, true);
  json["registration"] = to_json(report.registration);
  json["part_as_punctual_as_alone"] =
      both != nullptr && display != nullptr ? Json(part_as_punctual(*both, *display)) : Json(nullptr);
  json["part_of_picture_rate_alone"] =
      both != nullptr && extraction != nullptr
          ? Json(summary_of(*both).pictures_per_second / summary_of(*extraction).pictures_per_second)
          : Json(nullptr);
  return json.dump(1) + "\n";
}

}  // namespace foreview
