#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "foreview/recordings/builtin.h"
#include "foreview/viewer/evaluation.h"
#include "foreview/viewer/evaluation_report.h"
#include "gpu/gl_test_fixture.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

class EvaluationOfRecordings : public GlTest {
 protected:
  static EvaluationSummary summary_of(const EvaluationOptions& options, std::size_t instants) {
    Replayer replayer(options.replay);
    const Evaluation evaluation = evaluate(replayer, options);
    EXPECT_EQ(evaluation.instants.size(), instants);
    std::fputs(evaluation_table(evaluation, options).c_str(), stdout);
    return summarise(evaluation);
  }
};

// Sixteen instants of the workcell while head and arm move, a quarter of the size: few enough for a test. Measured:
// predicted 23.57 dB, 7.9 better than delayed and 8.3 than rotation; 29.9 dB over seen surface.
TEST_F(EvaluationOfRecordings, ShortWorkcell) {
  const test::TemporaryDirectory directory;
  GenerateOptions generate;
  generate.name = "workcell";
  generate.first_picture = 100;
  generate.pictures = 16;
  generate.scale = 0.25;
  generate_recording(generate, directory / "workcell");
  EvaluationOptions options;
  options.replay.recording = directory / "workcell";
  options.replay.delay = Duration::parse("400ms", "delay");
  options.replay.from = "#14";
  options.replay.history = 2;
  options.replay.density = 100;
  const EvaluationSummary summary = summary_of(options, 2);
  EXPECT_NEAR(summary.age, 0.44, 1e-6);
  EXPECT_GT(summary.seen, 0.45);
  EXPECT_GT(summary.psnr_over_seen.mean, 28);
  EXPECT_GT(summary.predicted.psnr.mean, summary.delayed.psnr.mean + 7);
  EXPECT_GT(summary.predicted.psnr.mean, summary.rotation.psnr.mean + 7);
  EXPECT_GT(summary.beyond_silhouettes.pixels, 1000U);
  EXPECT_GT(summary.beyond_silhouettes.psnr().value(), 25);
}

// A pan encoder that is off by one degree puts occluders' colours on what is behind them, 5 pixels wide at half the
// size.
TEST_F(EvaluationOfRecordings, SuppressionRemovesGhostsOfAPoseError) {
  const test::TemporaryDirectory directory;
  GenerateOptions generate;
  generate.name = "workcell";
  generate.first_picture = 80;
  generate.pictures = 24;
  generate.scale = 0.5;
  generate.errors.pose_degrees = 1;
  generate_recording(generate, directory / "workcell");
  EvaluationOptions options;
  options.replay.recording = directory / "workcell";
  options.replay.from = "#23";
  options.replay.density = 120;
  options.replay.extraction.artefacts = ArtefactSuppression::none;
  const EvaluationSummary before = summary_of(options, 1);
  options.replay.extraction.artefacts = ArtefactSuppression::diamond;
  options.replay.extraction.passes = 5;
  const EvaluationSummary after = summary_of(options, 1);
  EXPECT_LT(after.ghosts.rms(), before.ghosts.rms() * 2 / 3);
  EXPECT_LT(after.beyond_silhouettes.rms(), before.beyond_silhouettes.rms());
  EXPECT_GT(after.predicted.psnr.mean, before.predicted.psnr.mean - 0.05);
}

// The thresholds leave some room, for other renderers, below what was measured: 21.64 dB and 0.741, over seen surface
// 22.83 dB.
TEST_F(EvaluationOfRecordings, FewPicturesOfTheKitchen) {
  const std::filesystem::path directory = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::is_directory(directory)) GTEST_SKIP() << directory << " is not there";
  EvaluationOptions options;
  options.replay.recording = directory;
  options.replay.scene = "scene_5k.ply";
  options.replay.from = "#320";
  options.replay.to = "#530";
  options.replay.history = 1;
  options.replay.density = 200;
  options.every = 210;
  const EvaluationSummary summary = summary_of(options, 2);
  EXPECT_NEAR(summary.age, 16 / 30.0, 1e-3);
  EXPECT_GT(summary.predicted.psnr.mean, 21);
  EXPECT_GT(summary.predicted.ssim.mean, 0.72);
  EXPECT_GT(summary.predicted.psnr.mean, summary.rotation.psnr.mean + 5);
  EXPECT_GT(summary.psnr_over_seen.mean, 22);
}

// Measured: 23.58 dB, over seen surface 24.60 dB; with registration 23.73 and 24.81 dB.
TEST_F(EvaluationOfRecordings, RegistrationBringsTheKitchensTexturesTogether) {
  const std::filesystem::path directory = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::is_directory(directory)) GTEST_SKIP() << directory << " is not there";
  EvaluationOptions options;
  options.replay.recording = directory;
  options.replay.scene = "scene_5k.ply";
  options.replay.delay = Duration::parse("100ms", "delay");
  options.replay.from = "#205";
  options.replay.to = "#235";
  options.replay.density = 100;
  options.every = 15;
  options.replay.registration = false;
  const EvaluationSummary before = summary_of(options, 3);
  options.replay.registration = true;
  const EvaluationSummary after = summary_of(options, 3);
  EXPECT_GT(after.psnr_over_seen.mean, before.psnr_over_seen.mean + 0.1);
  EXPECT_GT(after.predicted.psnr.mean, before.predicted.psnr.mean + 0.05);
}

}  // namespace
}  // namespace foreview
