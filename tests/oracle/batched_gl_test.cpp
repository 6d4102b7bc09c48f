// The batched pipeline against the oracle of its rules.
#include <filesystem>

#include "foreview/gpu/batched/batched_extraction.h"
#include "foreview/recordings/builtin.h"
#include "foreview/recordings/recording.h"
#include "gpu/gl_test_fixture.h"
#include "oracle/batched_comparison.h"
#include "oracle/random_scene.h"
#include "support/temporary_directory.h"

namespace foreview::oracle {
namespace {

using BatchedOracle = GlTest;

ChartOptions charts_of(double density, int max_texels = 256, int page_size = 1024) {
  ChartOptions charts;
  charts.texels_per_metre = density;
  charts.max_texels = max_texels;
  charts.page_size = page_size;
  return charts;
}

void compare(const PolygonModel& model, const std::vector<CameraFrame>& pictures, const ChartOptions& charts,
             const ExtractionOptions& options, BatchedFigures& figures) {
  TextureStore store(model, lay_out_charts(model, charts));
  BatchedExtraction gl(store, options);
  BatchedComparison comparison(model, store, gl, options, figures);
  for (const CameraFrame& picture : pictures) comparison.add_picture(picture);
}

/// Of a random scene, the third picture is late.
void compare_random(unsigned seed, DistortionModel distortion, bool backdrop, int passes, const ChartOptions& charts,
                    BatchedFigures& figures) {
  const RandomScene scene = random_scene(seed, distortion, backdrop);
  ExtractionOptions options;
  options.artefacts = passes > 0 ? ArtefactSuppression::diamond : ArtefactSuppression::none;
  options.passes = passes;
  compare(scene.model,
          {scene.frame, moved(scene, seed + 100, Timestamp{3'000'000}), moved(scene, seed + 200, Timestamp{2'000'000})},
          charts, options, figures);
}

TEST_F(BatchedOracle, RandomScenes) {
  BatchedFigures figures;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    compare_random(seed, DistortionModel::none, seed % 2 == 0, static_cast<int>(seed) - 1, charts_of(80, 64), figures);
  }
  figures.expect_agreement("random scenes");
}

TEST_F(BatchedOracle, DistortedPictures) {
  BatchedFigures figures;
  for (unsigned seed = 51; seed < 55; ++seed) {
    compare_random(seed, DistortionModel::plumb_bob, true, 2, charts_of(80, 64), figures);
  }
  compare_random(57, DistortionModel::fisheye, true, 2, charts_of(80, 64), figures);
  figures.expect_agreement("random scenes, distorted pictures");
}

TEST_F(BatchedOracle, CoarseTextures) {
  BatchedFigures figures;
  for (unsigned seed = 61; seed < 64; ++seed) {
    compare_random(seed, DistortionModel::none, false, 1, charts_of(10, 16), figures);
  }
  figures.expect_agreement("random scenes, 10 texels/m");
}

TEST_F(BatchedOracle, FineTextures) {
  BatchedFigures figures;
  compare_random(62, DistortionModel::none, true, 1, charts_of(400, 256), figures);
  figures.expect_agreement("a random scene, 400 texels/m");
}

void compare_recording(const std::string& name, const std::vector<std::size_t>& numbers, double density,
                       const std::string& what) {
  const test::TemporaryDirectory directory;
  GenerateOptions generate;
  generate.name = name;
  std::vector<CameraFrame> pictures;
  std::optional<PolygonModel> model;
  for (const std::size_t number : numbers) {
    generate.pictures = 1;
    generate.first_picture = number;
    const auto place = directory / (name + std::to_string(number));
    generate_recording(generate, place);
    Recording recording = Recording::open(place);
    ASSERT_TRUE(recording.scene_file().has_value());
    if (!model) model = import_model(*recording.scene_file(), recording.import_options());
    std::optional<CameraFrame> picture = recording.read_frame(0, 0, *model);
    ASSERT_TRUE(picture.has_value());
    pictures.push_back(std::move(*picture));
  }
  BatchedFigures figures;
  compare(*model, pictures, charts_of(density, 256, 2048), ExtractionOptions(), figures);
  figures.expect_agreement(what);
}

TEST_F(BatchedOracle, Workcell) {
  compare_recording("workcell", {20, 150, 290}, 100, "workcell, pictures 20, 150, 290, 100 texels/m");
}

TEST_F(BatchedOracle, Cube) {
  compare_recording("cube", {0, 60}, 100, "cube, pictures 0, 60, 100 texels/m");
}

TEST_F(BatchedOracle, Kitchen) {
  const std::filesystem::path directory = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::exists(directory / "rgb.txt")) GTEST_SKIP() << "no kitchen recording at " << directory;
  Recording recording = Recording::open(directory);
  const PolygonModel model = import_model(directory / "scene_5k.ply", recording.import_options());
  std::vector<CameraFrame> pictures;
  for (const std::size_t number : {std::size_t{300}, std::size_t{330}}) {
    std::optional<CameraFrame> picture = recording.read_frame(0, number, model);
    ASSERT_TRUE(picture.has_value());
    pictures.push_back(std::move(*picture));
  }
  BatchedFigures figures;
  compare(model, pictures, charts_of(100, 256, 2048), ExtractionOptions(), figures);
  figures.expect_agreement("kitchen, pictures 300, 330, 100 texels/m");
}

}  // namespace
}  // namespace foreview::oracle
