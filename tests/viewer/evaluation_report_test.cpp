#include "foreview/viewer/evaluation_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "foreview/scene/errors.h"
#include "foreview/viewer/extraction_names.h"

namespace foreview {
namespace {

InstantScore instant(const std::string& stem, double psnr, double ssim, PixelError beyond) {
  InstantScore score;
  score.stem = stem;
  score.predicted = {psnr, ssim};
  score.delayed = {psnr - 10, ssim - 0.2};
  score.rotation = {psnr - 6, ssim - 0.1};
  score.seen = 0.75;
  score.filled = 0.2;
  score.never_seen = 0.05;
  score.over_seen = {100, 25, 4};
  score.beyond_silhouettes = beyond;
  score.age = 0.52;
  return score;
}

Evaluation example() {
  Evaluation evaluation;
  evaluation.instants = {instant("a", 20, 0.8, {30, 100, 8}), instant("b", 26, 0.7, {10, 20, 2}),
                         instant("c", 23, 0.9, {})};
  evaluation.recording = "example";
  evaluation.renderer = "some GL";
  evaluation.pictures_extracted = 8;
  evaluation.extraction_seconds = 0.4;
  return evaluation;
}

TEST(EvaluationReport, SummaryOfThreeInstants) {
  const EvaluationSummary summary = summarise(example());
  EXPECT_DOUBLE_EQ(summary.predicted.psnr.mean, 23);
  EXPECT_DOUBLE_EQ(summary.predicted.psnr.worst, 20);
  EXPECT_EQ(summary.predicted.psnr.worst_stem, "a");
  EXPECT_NEAR(summary.predicted.ssim.mean, 0.8, 1e-12);
  EXPECT_EQ(summary.predicted.ssim.worst_stem, "b");
  EXPECT_DOUBLE_EQ(summary.delayed.psnr.mean, 13);
  EXPECT_DOUBLE_EQ(summary.rotation.psnr.worst, 14);
  EXPECT_NEAR(summary.seen + summary.filled + summary.never_seen, 1, 1e-12);
  EXPECT_NEAR(summary.age, 0.52, 1e-12);
  // Pixels of all instants together, not the mean of the instants.
  EXPECT_EQ(summary.beyond_silhouettes.pixels, 40U);
  EXPECT_NEAR(summary.beyond_silhouettes.mean_squared, (30 * 100 + 10 * 20) / 40.0, 1e-12);
  EXPECT_NEAR(summary.beyond_silhouettes.mean_absolute, (30 * 8 + 10 * 2) / 40.0, 1e-12);
}

TEST(EvaluationReport, JsonHasFormatVersionSummaryAndInstants) {
  EvaluationOptions options;
  options.every = 15;
  options.replay.history = 3;
  const auto json = nlohmann::json::parse(evaluation_json(example(), options));
  EXPECT_EQ(json.at("format"), "foreview-evaluation");
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_EQ(json.at("options").at("every"), 15);
  EXPECT_EQ(json.at("options").at("history"), 3);
  EXPECT_EQ(json.at("options").at("delay"), 0.5);
  EXPECT_EQ(json.at("options").at("artefacts"), "diamond");
  EXPECT_EQ(json.at("options").at("fill"), "pyramid");
  EXPECT_EQ(json.at("renderer"), "some GL");
  EXPECT_DOUBLE_EQ(json.at("summary").at("predicted").at("psnr").at("mean").get<double>(), 23);
  EXPECT_DOUBLE_EQ(json.at("summary").at("milliseconds_per_picture").get<double>(), 50);
  ASSERT_EQ(json.at("instants").size(), 3U);
  EXPECT_EQ(json.at("instants")[1].at("stem"), "b");
  EXPECT_DOUBLE_EQ(json.at("instants")[0].at("beyond_silhouettes").at("rms").get<double>(), 10);
  // Where there is no pixel there is no figure.
  EXPECT_TRUE(json.at("instants")[2].at("beyond_silhouettes").at("psnr").is_null());
  EXPECT_EQ(json.at("instants")[2].at("beyond_silhouettes").at("pixels"), 0);
}

TEST(EvaluationReport, InterruptedBeforeTheFirstInstantIsStillAReport) {
  Evaluation evaluation;
  evaluation.complete = false;
  const auto json = nlohmann::json::parse(evaluation_json(evaluation, {}));
  EXPECT_EQ(json.at("complete"), false);
  EXPECT_TRUE(json.at("summary").at("predicted").at("psnr").is_null());
  EXPECT_TRUE(json.at("instants").empty());
  EXPECT_NE(evaluation_table(evaluation, {}).find("interrupted"), std::string::npos);
}

TEST(EvaluationReport, NamesThatAreNotUtf8MakeNoBrokenJson) {
  Evaluation evaluation = example();
  evaluation.instants[0].stem = "caf\xe9";
  const auto json = nlohmann::json::parse(evaluation_json(evaluation, {}));
  EXPECT_EQ(json.at("instants")[0].at("stem"), "caf\uFFFD");
}

TEST(EvaluationReport, TableSaysWhatMatters) {
  const std::string table = evaluation_table(example(), {});
  EXPECT_NE(table.find("predicted"), std::string::npos);
  EXPECT_NE(table.find("23.00"), std::string::npos) << table;
  EXPECT_NE(table.find("seen 75.0 %, filled 20.0 %, never seen 5.0 %"), std::string::npos) << table;
  EXPECT_NE(table.find("beyond silhouettes"), std::string::npos);
  EXPECT_NE(table.find("50.0 ms each"), std::string::npos) << table;
  EXPECT_NE(table.find("some GL"), std::string::npos);
}

TEST(ExtractionNames, ReadBackAndRefuseOthers) {
  for (const auto rule : {ArtefactSuppression::none, ArtefactSuppression::diamond, ArtefactSuppression::alternating,
                          ArtefactSuppression::progressive}) {
    EXPECT_EQ(parse_artefact_suppression(to_string(rule), "--artefacts"), rule);
  }
  for (const auto rule : {HoleFilling::none, HoleFilling::pyramid, HoleFilling::iterative}) {
    EXPECT_EQ(parse_hole_filling(to_string(rule), "--fill"), rule);
  }
  try {
    (void)parse_hole_filling("piramid", "--fill");
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "--fill: 'piramid' is none of its values: pyramid, iterative, none");
  }
  EXPECT_THROW((void)parse_artefact_suppression("", "--artefacts"), InputError);
}

}  // namespace
}  // namespace foreview
