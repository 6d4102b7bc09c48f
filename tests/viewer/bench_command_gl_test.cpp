// foreview bench as a user runs it. How long anything takes is no condition.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "support/slow_build.h"
#include "support/temporary_directory.h"
#include "viewer/run_foreview.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

using nlohmann::json;
using test::Finished;
using test::run_foreview;
using test::RunningForeview;
using test::TemporaryDirectory;
using test::WallRecording;

constexpr int kPictures = 6;

class BenchCommand : public ::testing::Test {
 protected:
  BenchCommand() { WallRecording::write(directory_.path() / "wall", kPictures); }
  [[nodiscard]] std::string path(const char* name) const { return (directory_.path() / name).string(); }
  [[nodiscard]] std::string read(const char* name) const { return directory_.read(name); }
  [[nodiscard]] json read_json(const char* name) const { return json::parse(directory_.read(name)); }

 private:
  TemporaryDirectory directory_;
};

/// What holds of every run that was measured.
void expect_sound(const json& run) {
  for (const json& cost : run["totals"]) {
    EXPECT_GT(cost["total_ms"], 0);
    EXPECT_LE(cost["cpu_ms"], cost["total_ms"]);
  }
  for (const json& cost : run["stepped"]) {
    double sum = 0;
    for (const auto& [step, ms] : cost["steps_ms"].items()) {
      EXPECT_GE(ms.get<double>(), 0) << step;
      sum += ms.get<double>();
    }
    EXPECT_NEAR(sum, cost["total_ms"].get<double>(), 1e-6 * sum + 1e-9);
  }
}

TEST_F(BenchCommand, MeasuresARecordingByStep) {
  const Finished run = run_foreview({"bench", path("wall"), "--pipeline", "per-polygon", "--density", "40", "--json",
                                     path("b.json"), "--html", path("b.html"), "--trace", path("b.trace"), "--stats"});
  ASSERT_EQ(run.status, 0) << run.err;
  for (const char* said : {"GL: ", "timing: ", "filling", "sum of the steps", "total, nothing waiting between",
                           "pictures a second without decoding", "counters of the run", "observed"}) {
    EXPECT_NE(run.out.find(said), std::string::npos) << said << "\n" << run.out;
  }
  const json report = read_json("b.json");
  EXPECT_EQ(report["format"], "foreview-bench");
  EXPECT_EQ(report["version"], 1);
  EXPECT_EQ(report["kind"], "recording");
  EXPECT_TRUE(report["complete"]);
  const std::string method = report["machine"]["timer_method"];
  ASSERT_EQ(report["runs"].size(), 1U);
  const json& measured = report["runs"][0];
  EXPECT_EQ(measured["pipeline"], "per-polygon");
  EXPECT_EQ(measured["step_timing"], method);
  EXPECT_EQ(measured["totals"].size(), static_cast<std::size_t>(kPictures));
  EXPECT_EQ(measured["stepped"].size(), static_cast<std::size_t>(kPictures));
  EXPECT_EQ(measured["density"], 40);
  expect_sound(measured);
  const json& counters = measured["counters"];
  EXPECT_EQ(counters["pictures_extracted"], kPictures);
  EXPECT_EQ(counters["pictures_damaged"], 0);
  std::size_t written = 0;
  for (const json& cost : measured["totals"]) written += cost["texels_written"].get<std::size_t>();
  EXPECT_GT(written, 0U);
  EXPECT_EQ(counters["texels_written"], written);
  EXPECT_GT(counters["texels_observed"], 0);
  EXPECT_LE(counters["texels_observed"], written);

  const std::string html = read("b.html");
  EXPECT_NE(html.find("</html>"), std::string::npos);
  EXPECT_EQ(html.find("http"), std::string::npos);
  // Spans of a track begin and end one after the other.
  const json trace = read_json("b.trace");
  std::map<std::pair<int, int>, double> ends;
  std::size_t spans = 0;
  for (const json& event : trace["traceEvents"]) {
    if (event["ph"] != "X") continue;
    ++spans;
    double& end = ends[{event["pid"].get<int>(), event["tid"].get<int>()}];
    EXPECT_GE(event["ts"].get<double>(), end - 1e-3);
    end = event["ts"].get<double>() + event["dur"].get<double>();
  }
  EXPECT_EQ(ends.size(), 3U);
  EXPECT_GT(spans, static_cast<std::size_t>(3 * kPictures));
}

TEST_F(BenchCommand, PipelinesStandSideBySideAndSayWhatTheyCannot) {
  const std::vector<std::string> arguments{"bench",     path("wall"), "--pipeline", "both",
                                           "--density", "20",         "--json",     path("b.json")};
  ASSERT_EQ(run_foreview(arguments).status, 0);
  const json both = read_json("b.json");
  ASSERT_EQ(both["runs"].size(), 2U);
  EXPECT_EQ(both["tables"][0]["columns"], json({"step", "batched", "%", "per-polygon", "%"}));
  for (const json& measured : both["runs"]) {
    EXPECT_TRUE(measured["unsupported"].is_null());
    EXPECT_EQ(measured["totals"].size(), static_cast<std::size_t>(kPictures));
    expect_sound(measured);
  }
  std::vector<std::string> iterative = arguments;
  iterative.insert(iterative.end(), {"--fill", "iterative"});
  const Finished run = run_foreview(iterative);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("with batched: --fill"), std::string::npos) << run.out;
  const json one = read_json("b.json");
  EXPECT_TRUE(one["runs"][0]["unsupported"].is_string());
  EXPECT_TRUE(one["runs"][0]["totals"].empty());
  EXPECT_EQ(one["runs"][1]["totals"].size(), static_cast<std::size_t>(kPictures));
}

TEST_F(BenchCommand, DamagedPicturesAreCountedAndLeftOut) {
  std::ofstream(path("wall") + "/rgb/000002.png") << "no picture";
  std::ofstream(path("wall") + "/rgb/000002.jpg") << "no picture";
  const Finished run = run_foreview(
      {"bench", path("wall"), "--pipeline", "per-polygon", "--density", "20", "--json", path("b.json"), "--stats"});
  ASSERT_EQ(run.status, 0) << run.err;
  const json measured = read_json("b.json")["runs"][0];
  EXPECT_EQ(measured["totals"].size(), static_cast<std::size_t>(kPictures - 1));
  EXPECT_EQ(measured["counters"]["pictures_damaged"], 1);
  EXPECT_EQ(measured["counters"]["pictures_in"], kPictures);
}

TEST_F(BenchCommand, GrowthInAGeneratedRoom) {
  const Finished run =
      run_foreview({"bench", "scaling", "--pipeline", "per-polygon", "--most-polygons", "300", "--most-megapixels",
                    "0.6", "--pictures", "1", "--json", path("s.json"), "--html", path("s.html")});
  ASSERT_EQ(run.status, 0) << run.err << run.out;
  EXPECT_NE(run.out.find("twice the polygons at equal texels"), std::string::npos) << run.out;
  const json report = read_json("s.json");
  ASSERT_EQ(report["curves"].size(), 3U);
  for (const json& curve : report["curves"]) {
    ASSERT_GE(curve["points"].size(), 2U);
    EXPECT_FALSE(curve["fit"].is_null());
    double before = 0;
    for (const json& point : curve["points"]) {
      EXPECT_GT(point["x"], before);
      before = point["x"];
      expect_sound(report["runs"][point["run"].get<std::size_t>()]);
    }
  }
}

TEST_F(BenchCommand, CtrlCLeavesWholeFiles) {
  RunningForeview running({"bench", "scaling", "--pipeline", "per-polygon", "--json", path("s.json")});
  for (int i = 0; i < 600 && running.standard_output().find("timing: ") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  running.send_signal(SIGINT);
  EXPECT_EQ(running.wait(60), 130) << running.standard_error();
  EXPECT_FALSE(read_json("s.json")["complete"]);
  EXPECT_NE(running.standard_output().find("interrupted"), std::string::npos);
}

TEST_F(BenchCommand, MistakesEndInOneLine) {
  const std::string wall = path("wall");
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"bench"},
                                             {"bench", "/nowhere"},
                                             {"bench", "tables", wall},
                                             {"bench", wall, "tables"},
                                             {"bench", "tables", "--pipeline", "fast"},
                                             {"bench", "--density", "100", "tables"},
                                             {"bench", "--from", "#2", "scaling"},
                                             {"bench", wall, "--delay", "1s"},
                                             {"bench", wall, "--pictures", "0"},
                                             {"bench", wall, "--json", "/nowhere/b.json"},
                                             {"bench", wall, "--html", wall},
                                             {"bench", wall, "--from", "#5", "--to", "#2"},
                                             {"bench", wall, "--fill", "grout"},
                                             {"bench", "scaling", "--most-megapixels", "many"},
                                             {"bench", "scaling", "--most-polygons", "-3"}}) {
    const Finished run = run_foreview(arguments);
    std::string given;
    for (const std::string& argument : arguments) given += argument + " ";
    EXPECT_EQ(run.status, 2) << given << run.err;
    std::istringstream stream(run.err);
    int errors = 0;
    for (std::string line; std::getline(stream, line);) errors += line.starts_with("foreview: ");
    EXPECT_EQ(errors, 1) << given << run.err;
  }
}

TEST_F(BenchCommand, HandingTexturesOverIsMeasuredWhereTheyAreBuffered) {
  const std::vector<std::string> arguments{"bench",     path("wall"), "--pipeline", "per-polygon",
                                           "--density", "40",         "--stats",    "--json"};
  std::vector<std::string> direct = arguments, buffered = arguments;
  direct.push_back(path("direct.json"));
  buffered.insert(buffered.end(), {path("buffered.json"), "--buffered"});
  ASSERT_EQ(run_foreview(direct).status, 0);
  ASSERT_EQ(run_foreview(buffered).status, 0);
  const json one = read_json("direct.json"), three = read_json("buffered.json");
  EXPECT_EQ(three["options"]["publishing"], "buffered");
  EXPECT_EQ(three["runs"][0]["counters"]["texture_bytes"], 3 * one["runs"][0]["counters"]["texture_bytes"].get<long>());
  expect_sound(three["runs"][0]);
}

/// Tables 7.1-7.4 on a few small pictures.
TEST_F(BenchCommand, TheTablesOf2005) {
  const Finished run = run_foreview({"bench", "tables", "--quick", "--pipeline", "per-polygon", "--pictures", "1",
                                     "--json", path("t.json"), "--html", path("t.html")},
                                    {{"FOREVIEW_CACHE", path("cache")}});
  ASSERT_EQ(run.status, 0) << run.err << run.out;
  const json report = read_json("t.json");
  ASSERT_EQ(report["tables"].size(), 4U);
  const std::vector<std::string> ids{"7.1", "7.2", "7.3", "7.4"};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const json& table = report["tables"][i];
    EXPECT_EQ(table["id"], ids[i]);
    for (const json& row : table["rows"]) EXPECT_EQ(row["cells"].size() + 1, table["columns"].size()) << row;
  }
  // All variants are measured, and 2005's figures stand beside them.
  for (std::size_t i = 1; i < ids.size(); ++i) {
    for (const json& row : report["tables"][i]["rows"]) {
      for (const json& cell : row["cells"]) EXPECT_FALSE(cell.is_null()) << row;
    }
  }
  EXPECT_EQ(report["tables"][0]["rows"][5]["cells"][0], 66.2);
  EXPECT_EQ(report["tables"][3]["rows"][6]["cells"][0], 464.7);
  for (const json& measured : report["runs"]) {
    EXPECT_TRUE(measured["complete"]);
    expect_sound(measured);
  }
}

/// Table 7.5 needs the pipeline that can be cut into slices.
TEST_F(BenchCommand, TheTableOf2005BesideADisplay) {
  const Finished run =
      run_foreview({"bench", "tables", "--quick", "--pipeline", "batched", "--pictures", "1", "--json", path("t.json")},
                   {{"FOREVIEW_CACHE", path("cache")}});
  ASSERT_EQ(run.status, 0) << run.err << run.out;
  const json report = read_json("t.json");
  ASSERT_EQ(report["tables"].size(), 5U);
  const json& table = report["tables"][4];
  EXPECT_EQ(table["id"], "7.5");
  ASSERT_EQ(table["rows"].size(), 5U);
  EXPECT_EQ(table["rows"][4]["label"], "100");
  EXPECT_EQ(table["rows"][4]["cells"][4], 613.7);
  for (std::size_t i = 0; i < 5; ++i) {
    const json& cells = table["rows"][i]["cells"];
    EXPECT_EQ(cells.size() + 1, table["columns"].size());
    // Beside no display there is no rate. How many pictures half a second gives beside one, no test can know.
    for (const std::size_t rate : {2U, 3U, 6U, 7U}) EXPECT_EQ(cells[rate].is_null(), i == 0) << cells;
  }
  if (!test::kIsSlowBuild) {
    EXPECT_GT(table["rows"][0]["cells"][1], 0);
  }
}

}  // namespace
}  // namespace foreview
