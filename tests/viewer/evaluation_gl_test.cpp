#include "foreview/viewer/evaluation.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "foreview/scene/errors.h"
#include "foreview/viewer/evaluation_report.h"
#include "gpu/gl_test_fixture.h"
#include "support/temporary_directory.h"
#include "viewer/small_recording.h"

namespace foreview {
namespace {

class EvaluationTest : public GlTest {
 protected:
  [[nodiscard]] EvaluationOptions options() const {
    EvaluationOptions result;
    result.replay.recording = directory_ / "recording";
    result.replay.delay = Duration::parse("200ms", "delay");
    result.replay.density = 60;
    return result;
  }
  static Evaluation run(const EvaluationOptions& options) {
    Replayer replayer(options.replay);
    return evaluate(replayer, options);
  }
  test::TemporaryDirectory directory_;
  test::SmallSite site_;
};

TEST_F(EvaluationTest, PredictsTheSmallSite) {
  site_.write(directory_ / "recording");
  EvaluationOptions with = options();
  with.images = directory_ / "images";
  const Evaluation evaluation = run(with);
  EXPECT_TRUE(evaluation.complete);
  EXPECT_EQ(evaluation.instants.size(), 7U);  // 3 ... 9
  EXPECT_EQ(evaluation.instants_without_picture, 3U);
  EXPECT_EQ(evaluation.instants_damaged, 0U);
  EXPECT_FALSE(evaluation.renderer.empty());
  const EvaluationSummary summary = summarise(evaluation);
  EXPECT_NEAR(summary.age, 0.3, 1e-6);
  EXPECT_GT(summary.psnr_over_seen.mean, 28) << evaluation_table(evaluation, with);
  EXPECT_GT(summary.predicted.psnr.mean, summary.delayed.psnr.mean + 5) << evaluation_table(evaluation, with);
  EXPECT_GT(summary.predicted.psnr.mean, summary.rotation.psnr.mean + 3) << evaluation_table(evaluation, with);
  EXPECT_GT(summary.predicted.ssim.mean, summary.delayed.ssim.mean);
  EXPECT_GT(summary.seen, 0.8);
  for (const InstantScore& instant : evaluation.instants) {
    EXPECT_NEAR(instant.seen + instant.filled + instant.never_seen, 1, 1e-9);
    EXPECT_EQ(instant.delayed_picture + 3, instant.picture);
    // A band of up to 12 pixels around a board of about 36 pixels.
    EXPECT_GT(instant.beyond_silhouettes.pixels, 500U);
    EXPECT_LT(instant.beyond_silhouettes.pixels, 2500U);
  }
  // The pictures on disk are those that were scored.
  const InstantScore& instant = evaluation.instants[2];
  const auto read = [&](const char* kind) {
    return cv::imread((directory_ / "images" / kind / (instant.stem + ".png")).string());
  };
  const cv::Mat truth = read("truth");
  EXPECT_EQ(cv::norm(truth, site_.render(0, site_.stamp(instant.picture)), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(read("delayed"), site_.render(0, site_.stamp(instant.delayed_picture)), cv::NORM_INF), 0);
  EXPECT_DOUBLE_EQ(pixel_error(read("predicted"), truth).psnr().value(), instant.predicted.psnr);
  EXPECT_DOUBLE_EQ(pixel_error(read("rotation"), truth).psnr().value(), instant.rotation.psnr);
}

TEST_F(EvaluationTest, EveryFromToAndHistory) {
  site_.write(directory_ / "recording");
  EvaluationOptions with = options();
  with.every = 2;
  with.replay.from = "#4";
  with.replay.to = "#9";
  with.replay.history = 1;
  const Evaluation evaluation = run(with);
  ASSERT_EQ(evaluation.instants.size(), 3U);
  EXPECT_EQ(evaluation.instants[0].picture, 4U);
  EXPECT_EQ(evaluation.instants[1].picture, 6U);
  EXPECT_EQ(evaluation.instants[2].picture, 8U);
  EXPECT_NEAR(evaluation.instants[1].seconds, 0.6, 1e-6);
  EXPECT_EQ(evaluation.pictures_extracted, 3U);
  // What the board hid in the only picture is not seen.
  EXPECT_LT(evaluation.instants[1].seen, run(options()).instants[3].seen);
}

TEST_F(EvaluationTest, DistortedPicturesAreComparedUndistorted) {
  site_.camera.distortion_model = DistortionModel::plumb_bob;
  site_.camera.distortion[0] = 0.12;  // pincushion: corners of the undistorted picture were never seen
  site_.instants = 6;
  site_.write(directory_ / "recording");
  EvaluationOptions with = options();
  with.images = directory_ / "images";
  const Evaluation evaluation = run(with);
  ASSERT_EQ(evaluation.instants.size(), 3U);
  EXPECT_GT(summarise(evaluation).psnr_over_seen.mean, 28) << evaluation_table(evaluation, with);
  EXPECT_GT(summarise(evaluation).predicted.psnr.mean, summarise(evaluation).delayed.psnr.mean + 5);
  test::SmallSite straight = site_;
  straight.camera = site_.camera.undistorted();
  const InstantScore& instant = evaluation.instants[0];
  const cv::Mat truth = cv::imread((directory_ / "images/truth" / (instant.stem + ".png")).string());
  const cv::Mat expected = straight.render(0, site_.stamp(instant.picture));
  const cv::Rect middle(16, 12, 64, 48);
  EXPECT_GT(pixel_error(truth(middle), expected(middle)).psnr().value(), 30);
  EXPECT_EQ(cv::norm(truth.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0), cv::NORM_INF), 0);
}

TEST_F(EvaluationTest, DamagedPictureInTheMiddleIsLeftOutAndTheRestGoesOn) {
  site_.write(directory_ / "recording");
  {
    const Recording recording = Recording::open(directory_ / "recording");
    const std::filesystem::path file = recording.cameras()[0].pictures[5].file;
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  }
  const Evaluation evaluation = run(options());
  EXPECT_EQ(evaluation.instants.size(), 6U);
  EXPECT_EQ(evaluation.instants_damaged, 1U);  // as truth at its own time ...
  EXPECT_EQ(evaluation.pictures_damaged, 1U);  // ... and as a delayed picture later
  EXPECT_EQ(evaluation.damage.pictures_unreadable, 1U);
  EXPECT_EQ(evaluation.instants.back().picture, 9U);
  const InstantScore& without = evaluation.instants[4];
  EXPECT_EQ(without.picture, 8U);
  EXPECT_EQ(without.delayed_picture, 4U);
  EXPECT_GT(summarise(evaluation).psnr_over_seen.mean, 28);
}

TEST_F(EvaluationTest, NoPolygonInView) {
  site_.instants = 5;
  site_.write(directory_ / "recording");
  RawMesh behind = test::SmallSite::mesh();
  for (glm::dvec3& vertex : behind.vertices) vertex.z -= 10;
  write_obj(behind, directory_ / "recording/behind.obj");
  EvaluationOptions with = options();
  with.replay.scene = "behind.obj";
  const Evaluation evaluation = run(with);
  ASSERT_EQ(evaluation.instants.size(), 2U);
  EXPECT_EQ(evaluation.instants[0].seen, 0);
  EXPECT_EQ(evaluation.instants[0].never_seen, 1);
  EXPECT_FALSE(evaluation.instants[0].over_seen.psnr().has_value());
  EXPECT_EQ(evaluation.instants[0].beyond_silhouettes.pixels, 0U);
  EXPECT_FALSE(evaluation_json(evaluation, with).empty());
  EXPECT_NE(evaluation_table(evaluation, with).find("no pixels"), std::string::npos);
}

TEST_F(EvaluationTest, InterruptionKeepsWhatIsDone) {
  site_.write(directory_ / "recording");
  const EvaluationOptions with = options();
  Replayer replayer(with.replay);
  const Evaluation evaluation = evaluate(replayer, with, [](std::size_t done, std::size_t todo) {
    EXPECT_EQ(todo, 10U);
    if (done == 5) throw Interrupted();
  });
  EXPECT_FALSE(evaluation.complete);
  EXPECT_EQ(evaluation.instants.size(), 2U);
}

TEST_F(EvaluationTest, NothingToEvaluateIsAnError) {
  site_.instants = 3;
  site_.write(directory_ / "recording");
  EXPECT_THROW((void)run(options()), InputError);
}

TEST_F(EvaluationTest, OnePixelPictures) {
  site_.camera.width = site_.camera.height = 1;
  site_.camera.focal_length = {0.1, 0.1};
  site_.camera.principal_point = {0.5, 0.5};
  site_.instants = 5;
  site_.write(directory_ / "recording");
  EXPECT_EQ(run(options()).instants.size(), 2U);
}

TEST_F(EvaluationTest, SameInputSameFigures) {
  site_.instants = 6;
  site_.write(directory_ / "recording");
  Evaluation first = run(options()), second = run(options());
  first.extraction_seconds = second.extraction_seconds = 0;
  EXPECT_EQ(evaluation_json(first, options()), evaluation_json(second, options()));
}

}  // namespace
}  // namespace foreview
