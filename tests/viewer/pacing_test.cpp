#include "foreview/viewer/pacing.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "foreview/viewer/pacing_report.h"

namespace foreview {
namespace {

Duration ms(double milliseconds) {
  return {static_cast<std::int64_t>(milliseconds * 1e6)};
}

/// Frames due every 20 ms, complete so long after their due time.
PacingRun run_of(const std::vector<double>& completions, double drawing = 5) {
  PacingRun run;
  run.name = "run";
  run.period = ms(20);
  run.started = Timestamp{1'000'000'000};
  run.ended = run.started + ms(20.0 * static_cast<double>(completions.size()));
  for (std::size_t i = 0; i < completions.size(); ++i) {
    FrameRecord frame;
    frame.number = static_cast<std::int64_t>(i);
    frame.due = run.started + ms(20.0 * static_cast<double>(i + 1));
    frame.completed = frame.due + ms(completions[i]);
    frame.started = frame.completed - ms(drawing);
    run.add(frame);
  }
  return run;
}

TEST(Pacing, SumsUpWhatFramesDid) {
  PacingRun run = run_of({-1, -1, -1, 2, -1, -1, 7, -1, -1, -1});
  run.schedule.skipped = 2;
  run.schedule.missed = 3;
  const PacingSummary summary = summary_of(run);
  EXPECT_EQ(summary.frames, 10U);
  EXPECT_EQ(summary.late, 2U);
  EXPECT_EQ(summary.skipped, 2);
  EXPECT_EQ(summary.missed, 3);
  EXPECT_NEAR(summary.frames_per_second, 50, 1e-9);
  EXPECT_NEAR(summary.completion.mean, 0.1, 1e-9);
  EXPECT_NEAR(summary.completion.median, -1, 1e-9);
  EXPECT_NEAR(summary.completion.least, -1, 1e-9);
  EXPECT_NEAR(summary.completion.worst, 7, 1e-9);
  EXPECT_NEAR(summary.drawing.p99, 5, 1e-9);
  EXPECT_NEAR(summary.interval.worst, 28, 1e-9);
  EXPECT_NEAR(summary.interval.least, 12, 1e-9);
}

TEST(Pacing, FindsTheWorstSecond) {
  PacingRun run = run_of(std::vector<double>(300, -1));
  EXPECT_NEAR(summary_of(run).worst_frames_per_second, 50, 1);
  run.frames.erase(run.frames.begin() + 120, run.frames.begin() + 140);
  EXPECT_NEAR(summary_of(run).worst_frames_per_second, 30, 1);
}

TEST(Pacing, PunctualIsWithinAQuarterPeriodOfTheReferencesMean) {
  const PacingRun reference = run_of({-2, 0});  // -1 on average: 4 is the latest
  EXPECT_NEAR(part_as_punctual(run_of({-3, 3.9, 4.1, 9}), reference), 0.5, 1e-9);
  PacingRun run = run_of({-1, -1, -1});
  run.schedule.skipped = 1;
  EXPECT_NEAR(part_as_punctual(run, reference), 0.75, 1e-9) << "a frame that was skipped was not in time";
  run.schedule.missed = 2;
  EXPECT_NEAR(part_as_punctual(run, reference), 0.5, 1e-9);
}

TEST(Pacing, CountsAllFramesOfALongRun) {
  constexpr std::size_t kFrames = 5 * PacingRun::kKept;
  std::vector<double> completions(kFrames, -1);
  for (std::size_t i = 0; i < kFrames; i += 100) completions[i] = 7;
  PacingRun run = run_of(completions);
  ASSERT_GT(run.frames_dropped, 0U);
  PacingSummary summary = summary_of(run);
  EXPECT_EQ(summary.frames, kFrames);
  EXPECT_EQ(summary.late, kFrames / 100);
  EXPECT_NEAR(summary.frames_per_second, 50, 1e-9);
  EXPECT_NEAR(part_as_punctual(run, run_of({-1})), 0.99, 1e-4) << "of those kept";
  run.schedule.missed = 1'000;
  EXPECT_NEAR(part_as_punctual(run, run_of({-1})), 0.99, 1e-4) << "among those dropped";
  run.frames.erase(run.frames.end() - 11, run.frames.end() - 1);
  const double kept = static_cast<double>(run.frames.size());
  EXPECT_NEAR(part_as_punctual(run, run_of({-1})), 0.99 * kept / (kept + 10), 1e-4) << "missed at the end of the run";
}

TEST(Pacing, ALongRunDoesNotGrow) {
  PacingRun run;
  FrameRecord frame;
  for (std::size_t i = 0; i < 5 * PacingRun::kKept; ++i) {
    frame.number = static_cast<std::int64_t>(i);
    run.add(frame);
  }
  EXPECT_LE(run.frames.capacity(), 2 * PacingRun::kKept);
  EXPECT_GE(run.frames.size(), PacingRun::kKept);
  EXPECT_EQ(run.frames.size() + run.frames_dropped, 5 * PacingRun::kKept);
  EXPECT_EQ(run.frames.front().number, static_cast<std::int64_t>(run.frames_dropped));
}

TEST(Pacing, CountsWhatTheProcessHolds) {
  const ResourceCounts before = count_resources();
  EXPECT_GT(before.resident_bytes, 1U << 20);
  EXPECT_GE(before.open_files, 3U);
  EXPECT_GE(before.threads, 1U);
  std::vector<std::FILE*> files;
  for (int i = 0; i < 5; ++i) files.push_back(std::fopen("/dev/null", "r"));
  const std::vector<char> memory(64U << 20, 1);
  const ResourceCounts after = count_resources();
  for (std::FILE* file : files) std::fclose(file);
  EXPECT_EQ(after.open_files, before.open_files + 5);
  EXPECT_GE(after.resident_bytes, before.resident_bytes + (60U << 20)) << memory.size();
}

TEST(Pacing, ReportsAllThatIsComparedOnlyWhereItWasMeasured) {
  PacingReport report;
  report.recording = "wall";
  PacingRun both = run_of({-1, -1, 9, -1});
  both.name = "both";
  PictureRecord picture;
  picture.begun = both.started;
  picture.finished = both.started + ms(30);
  picture.displayed = both.started + ms(40);
  picture.age_when_displayed = ms(540);
  both.add(picture);
  report.runs = {both};
  nlohmann::json json = nlohmann::json::parse(pacing_json(report));
  EXPECT_EQ(json["format"], "foreview-pacing");
  EXPECT_EQ(json["version"], kPacingJsonVersion);
  EXPECT_TRUE(json["part_as_punctual_as_alone"].is_null());
  EXPECT_TRUE(json["part_of_picture_rate_alone"].is_null());
  ASSERT_EQ(json["runs"].size(), 1U);
  const nlohmann::json run = json["runs"][0];
  EXPECT_EQ(run["frames_late"], 1);
  EXPECT_NEAR(run["rate_wanted"].get<double>(), 50, 1e-9);
  EXPECT_NEAR(run["frames"][2]["completion_ms"].get<double>(), 69, 1e-6);
  EXPECT_NEAR(run["pictures"][0]["displayed_after_capture_ms"].get<double>(), 540, 1e-6);
  EXPECT_EQ(pacing_text(report).find("quarter"), std::string::npos);

  PacingRun alone = both;
  alone.frames.clear();
  alone.period = {};
  alone.add(picture);
  report.runs = {alone, run_of({-1, -1, -1, -1}), both};
  json = nlohmann::json::parse(pacing_json(report));
  EXPECT_NEAR(json["part_as_punctual_as_alone"].get<double>(), 0.75, 1e-9);
  EXPECT_NEAR(json["part_of_picture_rate_alone"].get<double>(), 0.5, 1e-9);
  EXPECT_TRUE(json["runs"][0]["rate_wanted"].is_null());
  EXPECT_NE(pacing_text(report).find("75.00 % of the frames"), std::string::npos) << pacing_text(report);
}

}  // namespace
}  // namespace foreview
