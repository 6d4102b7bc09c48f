#include "foreview/viewer/replay_options_cli.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

ReplayOptions parse(std::vector<std::string> arguments) {
  CLI::App app;
  ReplayOptions options;
  add_replay_options(app, options);
  add_pipeline_options(app, options);
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return options;
}

/// The error's text, or "taken".
std::string refusal(const std::vector<std::string>& arguments) {
  try {
    (void)parse(arguments);
    return "taken";
  } catch (const InputError& error) {
    return error.what();
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
}

TEST(ReplayOptionsCli, DefaultsAreThoseOfTheStructure) {
  const ReplayOptions options = parse({"workcell"}), defaults;
  EXPECT_EQ(options.recording, "workcell");
  EXPECT_EQ(options.delay, Duration{500'000'000});
  EXPECT_FALSE(options.scene || options.history || options.density || options.max_texels || options.load_textures);
  EXPECT_EQ(options.extraction.artefacts, ArtefactSuppression::diamond);
  EXPECT_EQ(options.extraction.passes, 3);
  EXPECT_EQ(options.extraction.fill, HoleFilling::pyramid);
}

TEST(ReplayOptionsCli, Exposure) {
  EXPECT_TRUE(parse({"workcell"}).extraction.compensate_exposure);
  EXPECT_TRUE(parse({"workcell", "--exposure", "auto"}).extraction.compensate_exposure);
  EXPECT_FALSE(parse({"workcell", "--exposure", "off"}).extraction.compensate_exposure);
  EXPECT_NE(refusal({"workcell", "--exposure", "on"}).find("--exposure"), std::string::npos);
}

TEST(ReplayOptionsCli, PipelineAndCounters) {
  EXPECT_EQ(parse({"workcell"}).pipeline, PipelineKind::batched);
  EXPECT_FALSE(parse({"workcell"}).stats);
  EXPECT_EQ(parse({"workcell", "--pipeline", "per-polygon"}).pipeline, PipelineKind::per_polygon);
  EXPECT_EQ(parse({"workcell", "--pipeline", "batched", "--stats"}).pipeline, PipelineKind::batched);
  EXPECT_TRUE(parse({"workcell", "--stats"}).stats);
  EXPECT_NE(refusal({"workcell", "--pipeline", "both"}).find("--pipeline"), std::string::npos);
}

TEST(ReplayOptionsCli, AllOptions) {
  const ReplayOptions options =
      parse({"some/where", "--scene",         "a.ply",       "--camera", "left",      "--delay",
             "0.25s",      "--from",          "#200",        "--to",     "12.5",      "--history",
             "7",          "--artefacts",     "alternating", "--passes", "2",         "--alpha-c",
             "3.25",       "--small-texture", "5",           "--fill",   "iterative", "--density",
             "125.5",      "--max-texels",    "512",         "--near",   "0.1",       "--load-textures",
             "in",         "--save-textures", "out"});
  EXPECT_EQ(options.recording, "some/where");
  EXPECT_EQ(options.scene, "a.ply");
  EXPECT_EQ(options.camera, "left");
  EXPECT_EQ(options.delay, Duration{250'000'000});
  EXPECT_EQ(options.from, "#200");
  EXPECT_EQ(options.to, "12.5");
  EXPECT_EQ(options.history, 7U);
  EXPECT_EQ(options.extraction.artefacts, ArtefactSuppression::alternating);
  EXPECT_EQ(options.extraction.passes, 2);
  EXPECT_EQ(options.extraction.alpha_c, 3.25);
  EXPECT_EQ(options.extraction.small_texture, 5);
  EXPECT_EQ(options.extraction.fill, HoleFilling::iterative);
  EXPECT_EQ(options.density, 125.5);
  EXPECT_EQ(options.max_texels, 512);
  EXPECT_EQ(options.extraction.near_plane, 0.1);
  EXPECT_EQ(options.load_textures, "in");
  EXPECT_EQ(options.save_textures, "out");
}

TEST(ReplayOptionsCli, RefusesWhatCannotBeAndNamesTheOption) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong{
      {"--delay", {"-5ms", "2h", "soon", "nan", "4000", ""}},
      {"--history", {"0", "-1", "1.5", "many", "99999999999999999999999", "3 "}},
      {"--artefacts", {"diamonds", "Diamond"}},
      {"--passes", {"-1", "65", "two"}},
      {"--alpha-c", {"2.99", "3.875", "nan", "inf"}},
      {"--small-texture", {"-1", "x"}},
      {"--fill", {"quick"}},
      {"--density", {"0", "-100", "nan", "inf", "1e9", "500t"}},
      {"--max-texels", {"0", "3", "20000", "256.5"}},
      {"--near", {"0", "-1", "nan"}}};
  for (const auto& [option, values] : wrong) {
    for (const std::string& value : values) {
      const std::string why = refusal({"workcell", option + "=" + value});
      EXPECT_EQ(why.find(option), 0U) << option << "=" << value << ": " << why;
    }
  }
  EXPECT_NE(refusal({}).find("RECORDING"), std::string::npos) << refusal({});
}

TEST(ReplayOptionsCli, CountsAreWholeAndPositive) {
  EXPECT_EQ(parse_count("15", "--every"), 15U);
  EXPECT_THROW((void)parse_count("0", "--every"), InputError);
  EXPECT_THROW((void)parse_count("1e3", "--every"), InputError);
}

}  // namespace
}  // namespace foreview
