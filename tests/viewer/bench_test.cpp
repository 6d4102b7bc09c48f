// What foreview bench computes without a GPU: statistics, fits, the generated room, reports.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "foreview/viewer/bench_html.h"
#include "foreview/viewer/bench_pictures.h"
#include "foreview/viewer/bench_recording.h"
#include "foreview/viewer/bench_report.h"
#include "foreview/viewer/bench_scene.h"
#include "foreview/viewer/bench_statistics.h"
#include "foreview/viewer/bench_svg.h"
#include "foreview/viewer/bench_table.h"
#include "foreview/viewer/bench_trace.h"

namespace foreview {
namespace {

TEST(BenchStatistics, QuartilesAreInterpolated) {
  const Quantiles q = quantiles_of({4, 1, 3, 2});
  EXPECT_EQ(q.count, 4U);
  EXPECT_DOUBLE_EQ(q.least, 1);
  EXPECT_DOUBLE_EQ(q.lower, 1.75);
  EXPECT_DOUBLE_EQ(q.median, 2.5);
  EXPECT_DOUBLE_EQ(q.upper, 3.25);
  EXPECT_DOUBLE_EQ(q.greatest, 4);
  EXPECT_DOUBLE_EQ(quantiles_of({7}).median, 7);
  EXPECT_DOUBLE_EQ(quantiles_of({7}).upper, 7);
  EXPECT_EQ(quantiles_of({}).count, 0U);
}

std::vector<double> costs(const std::vector<double>& sizes, auto&& cost) {
  std::vector<double> result;
  for (const double x : sizes) result.push_back(cost(x));
  return result;
}

const std::vector<double> kSizes{100, 300, 1000, 3000, 10'000, 30'000, 100'000};

TEST(BenchStatistics, FindsConstantAndSlopeOfALine) {
  const GrowthFit fit = fit_growth(kSizes, costs(kSizes, [](double x) { return 5 + 0.02 * x; }));
  EXPECT_NEAR(fit.constant, 5, 1e-9);
  EXPECT_NEAR(fit.slope, 0.02, 1e-12);
  EXPECT_LT(fit.exponent, 1);
  EXPECT_NEAR(fit.exponent_at_end, 1, 0.03);
  EXPECT_TRUE(fit.at_most_linear);
}

TEST(BenchStatistics, OneWildPointChangesLittle) {
  std::vector<double> t = costs(kSizes, [](double x) { return 5 + 0.02 * x; });
  t[2] *= 30;
  EXPECT_NEAR(fit_growth(kSizes, t).slope, 0.02, 0.002);
}

TEST(BenchStatistics, TellsFasterThanLinear) {
  const GrowthFit square = fit_growth(kSizes, costs(kSizes, [](double x) { return 1e-6 * x * x; }));
  EXPECT_NEAR(square.exponent, 2, 1e-9);
  EXPECT_FALSE(square.at_most_linear);
  // A constant hides the square over most of the sizes, but not at the end.
  const GrowthFit hidden = fit_growth(kSizes, costs(kSizes, [](double x) { return 50 + 1e-6 * x * x; }));
  EXPECT_LT(hidden.exponent, 1.1);
  EXPECT_FALSE(hidden.at_most_linear);
}

TEST(BenchPicturesTest, SpreadsOverAll) {
  EXPECT_EQ(spread_evenly(10, 3), (std::vector<std::size_t>{0, 5, 9}));
  EXPECT_EQ(spread_evenly(3, 10), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(spread_evenly(9, 1), (std::vector<std::size_t>{4}));
  EXPECT_TRUE(spread_evenly(0, 4).empty());
}

TEST(BenchPicturesTest, KeepsNoMoreThanMemoryAllows) {
  std::vector<std::size_t> decoded;
  BenchPictures pictures(
      {"a", "b", "c", "d", "e"},
      [&](std::size_t i) -> std::optional<CameraFrame> {
        decoded.push_back(i);
        if (i == 3) return std::nullopt;
        CameraFrame frame;
        frame.camera.width = static_cast<int>(i);
        return frame;
      },
      10, 20);
  ASSERT_NE(pictures.get(0), nullptr);
  EXPECT_EQ(decoded, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(pictures.get(1)->camera.width, 1);
  EXPECT_EQ(decoded.size(), 2U);
  EXPECT_EQ(pictures.get(2)->camera.width, 2);
  EXPECT_EQ(pictures.get(3), nullptr) << "damaged";
  EXPECT_EQ(pictures.get(4)->camera.width, 4);
  EXPECT_EQ(decoded, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

TEST(BenchScene, TheRoomIsClosedAndFacesInwards) {
  for (const std::size_t polygons : {std::size_t{12}, std::size_t{100}, std::size_t{1000}}) {
    const PolygonModel room = bumpy_room(polygons);
    const auto k = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(polygons) / 12)));
    ASSERT_EQ(room.polygons().size(), 12 * k * k);
    for (std::size_t i = 0; i < room.polygons().size(); ++i) {
      EXPECT_EQ(room.neighbours_of(i).size(), 3U);
      EXPECT_LT(glm::dot(room.polygons()[i].normal, room.corner(i, 0)), 0) << "the middle is in front";
    }
    EXPECT_EQ(room.fingerprint(), bumpy_room(polygons).fingerprint());
  }
}

TEST(BenchScene, CamerasHaveTheSizeAskedFor) {
  for (const double megapixels : {0.3, 1.2, 8.3}) {
    const CameraModel camera = room_camera(megapixels);
    EXPECT_NEAR(1e-6 * camera.width * camera.height, megapixels, 0.01 * megapixels);
    BenchPictures pictures = room_pictures(camera, 3);
    ASSERT_EQ(pictures.size(), 3U);
    const CameraFrame first = *pictures.get(0), second = *pictures.get(1);
    EXPECT_EQ(first.picture.cols, camera.width);
    EXPECT_EQ(first.picture.data, second.picture.data) << "pictures share their memory";
    EXPECT_LT(first.state.stamp, second.state.stamp);
    EXPECT_GT(angle_between(first.state.world_from_camera, second.state.world_from_camera), 1);
  }
}

TEST(BenchSvg, AxesEndAtRoundNumbers) {
  const SvgAxis linear = SvgAxis::around({3, 8, 47}, false, "");
  EXPECT_EQ(linear.low, 0);
  EXPECT_EQ(linear.high, 50);
  EXPECT_EQ(linear.ticks(), (std::vector<double>{0, 10, 20, 30, 40, 50}));
  EXPECT_DOUBLE_EQ(linear.part(25), 0.5);
  const SvgAxis logarithmic = SvgAxis::around({130, 0, 80'000}, true, "");
  EXPECT_NEAR(logarithmic.low, 100, 1e-9);
  EXPECT_NEAR(logarithmic.high, 100'000, 1e-6);
  EXPECT_NEAR(logarithmic.part(1000), 1.0 / 3, 1e-12);
  EXPECT_EQ(SvgAxis::around({}, true, "").ticks().size(), 4U);
}

TEST(BenchTableTest, SaysTheSameInTextHtmlAndJson) {
  BenchTable table;
  table.id = "9.9";
  table.title = "A <title>";
  table.unit = "ms";
  table.columns = {"step", "2005", "ours"};
  table.rows.push_back({"filling", {BenchCell::printed(66.2), BenchCell::measured(quantiles_of({1, 2, 3}))}, false});
  table.rows.push_back({"all", {BenchCell::note("-"), BenchCell::measured(Quantiles{})}, true});
  const std::string text = table_text(table);
  EXPECT_NE(text.find("filling  66.2  2.0 [1.5 2.5]\n"), std::string::npos) << text;
  const std::string html = table_html(table);
  EXPECT_NE(html.find("A &lt;title&gt;"), std::string::npos);
  EXPECT_EQ(html.find("<title>"), std::string::npos);
  const nlohmann::ordered_json json = table_json(table);
  EXPECT_EQ(json["rows"][0]["cells"][0], 66.2);
  EXPECT_EQ(json["rows"][0]["cells"][1]["median"], 2);
  EXPECT_EQ(json["rows"][0]["cells"][1]["count"], 3);
  EXPECT_TRUE(json["rows"][1]["cells"][1].is_null());
}

/// A report as measure() would leave it, of two pictures.
BenchReport small_report() {
  BenchReport report;
  report.kind = "recording";
  report.title = "a & b";
  report.machine.renderer = "a renderer";
  BenchRun& run = report.runs.emplace_back();
  run.request.subject = "wall";
  run.request.keep_spans = true;
  run.pictures = {"first", "second"};
  run.step_timing = ExtractionTiming::finish;
  for (std::size_t i = 0; i < 2; ++i) {
    PictureCost cost;
    cost.picture = i;
    cost.start_ms = 10.0 * static_cast<double>(i);
    cost.total_ms = 4 + static_cast<double>(i);
    cost.statistics.texels_written = 2'000'000;
    run.totals.push_back(cost);
    SteppedCost stepped;
    stepped.picture = i;
    stepped.start_ms = 100.0 + 10.0 * static_cast<double>(i);
    stepped.statistics.spans = {{ExtractionStep::upload, 0, 1, 0, 2}, {ExtractionStep::filling, 2, 2.5, 2, 6}};
    stepped.statistics.step_ms[static_cast<std::size_t>(ExtractionStep::upload)] = 2;
    stepped.statistics.step_ms[static_cast<std::size_t>(ExtractionStep::filling)] = 4;
    stepped.statistics.total_ms = 6;
    run.stepped.push_back(stepped);
  }
  run.complete = true;
  report.tables = {steps_table_of({&run}, "wall")};
  ScalingCurve& curve = report.curves.emplace_back();
  curve.id = "texels";
  curve.x_label = "texels";
  for (const double x : {1.0, 2.0, 4.0}) curve.points.push_back({x, quantiles_of({3 * x, 3 * x + 0.1}), 0});
  curve.fit = fit_growth(std::vector<double>{1, 2, 4}, std::vector<double>{3, 6, 12});
  report.complete = true;
  return report;
}

TEST(BenchReportTest, MillionTexelsAreAPartOfTheTotal) {
  const BenchReport report = small_report();
  EXPECT_EQ(report.runs[0].ms_per_million_texels(), (std::vector<double>{2, 2.5}));
}

TEST(BenchReportTest, JsonNamesFormatVersionAndEverySample) {
  const auto json = nlohmann::json::parse(report_json(small_report()));
  EXPECT_EQ(json["format"], "foreview-bench");
  EXPECT_EQ(json["version"], kBenchJsonVersion);
  EXPECT_EQ(json["machine"]["timer_method"], "finish");
  const auto& run = json["runs"][0];
  EXPECT_EQ(run["totals"].size(), 2U);
  EXPECT_EQ(run["total_ms"]["median"], 4.5);
  EXPECT_EQ(run["stepped"][1]["picture"], "second");
  EXPECT_EQ(run["stepped"][1]["steps_ms"].size(), kExtractionSteps);
  EXPECT_EQ(run["stepped"][1]["steps_ms"]["filling"], 4);
  EXPECT_EQ(json["curves"][0]["fit"]["exponent"], 1);
}

TEST(BenchReportTest, TraceHasBothTracksInMicroseconds) {
  const auto trace = nlohmann::json::parse(report_trace(small_report()));
  int cpu = 0, gpu = 0, pictures = 0, names = 0;
  for (const auto& event : trace["traceEvents"]) {
    if (event["ph"] == "M") {
      ++names;
      continue;
    }
    ASSERT_EQ(event["ph"], "X");
    EXPECT_GE(event["dur"].get<double>(), 0);
    cpu += event["cat"] == "cpu";
    gpu += event["cat"] == "gpu";
    pictures += event["cat"] == "picture";
    if (event["cat"] == "gpu" && event["name"] == "filling" && event["ts"] < 110'000) {
      EXPECT_DOUBLE_EQ(event["ts"], 102'000);
      EXPECT_DOUBLE_EQ(event["dur"], 4000);
    }
  }
  EXPECT_EQ(cpu, 4);
  EXPECT_EQ(gpu, 4);
  EXPECT_EQ(pictures, 2);
  EXPECT_EQ(names, 4);  // a process and its three tracks
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

TEST(BenchReportTest, ThePageNeedsNothingElse) {
  const std::string html = report_html(small_report());
  for (const char* outside : {"http", "src=", "href", "<script", "@import", "url("}) {
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  }
  for (const char* broken : {"nan", "inf\"", ">inf"}) EXPECT_EQ(html.find(broken), std::string::npos) << broken;
  EXPECT_NE(html.find("<h1>a &amp; b</h1>"), std::string::npos);
  for (const char* tag : {"svg", "g", "figure", "table", "div", "ul", "p", "text"}) {
    EXPECT_EQ(count(html, std::string("<") + tag + ">") + count(html, std::string("<") + tag + " "),
              count(html, std::string("</") + tag + ">"))
        << tag;
  }
  // Shares, the stacked pictures, the curve.
  EXPECT_EQ(count(html, "<figure>"), 3U);
  EXPECT_EQ(count(html, "<title>first\nupload 2.00 ms\nfilling 4.00 ms</title>"), 1U);
}

}  // namespace
}  // namespace foreview
