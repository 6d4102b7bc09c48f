// The GL pipeline against the oracle on whole pictures, as people use it.
#include <algorithm>
#include <filesystem>
#include <numeric>

#include "foreview/recordings/builtin.h"
#include "foreview/recordings/recording.h"
#include "gpu/gl_test_fixture.h"
#include "oracle/comparison.h"
#include "support/temporary_directory.h"

namespace foreview::oracle {
namespace {

using RecordingsOracle = GlTest;

constexpr std::size_t kPolygonsCompared = 40;

/// Compares the largest polygons in one picture, onto empty textures.
void compare_picture(const PolygonModel& model, const CameraFrame& picture, const ExtractionOptions& options,
                     const ChartOptions& charts, const std::string& what) {
  struct Candidate {
    std::size_t polygon = 0;
    int pixels = 0;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const ProjectedPolygon projected = project(model, i, picture.camera, picture.state, options.near_plane);
    if (skip_reason(projected) != Skip::none) continue;
    candidates.push_back({i, projected.box.width() * projected.box.height()});
  }
  ASSERT_GE(candidates.size(), kPolygonsCompared);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.pixels > b.pixels; });
  candidates.resize(kPolygonsCompared);

  TextureStore store(model, lay_out_charts(model, charts));
  PerPolygonExtraction extraction(store, charts, options);
  Comparison comparison(model, options, charts);
  const PreparedFrame frame = comparison.oracle().prepare(picture);
  comparison.add_undistorted(extraction.undistorted(picture), frame);
  for (const Candidate& candidate : candidates) {
    comparison.add_polygon(extraction.inspect(picture, static_cast<std::uint32_t>(candidate.polygon)), frame,
                           candidate.polygon);
  }
  comparison.expect_agreement(what);
}

ChartOptions charts_of(double density, int max_texels) {
  ChartOptions charts;
  charts.texels_per_metre = density;
  charts.max_texels = max_texels;
  charts.group_polygons = false;
  return charts;
}

TEST_F(RecordingsOracle, WorkcellPicture) {
  const test::TemporaryDirectory directory;
  GenerateOptions generate;
  generate.name = "workcell";
  generate.pictures = 1;
  generate.first_picture = 140;
  generate_recording(generate, directory / "workcell");
  Recording recording = Recording::open(directory / "workcell");
  ASSERT_TRUE(recording.scene_file().has_value());
  const PolygonModel model = import_model(*recording.scene_file(), recording.import_options());
  const std::optional<CameraFrame> picture = recording.read_frame(0, 0, model);
  ASSERT_TRUE(picture.has_value());
  EXPECT_TRUE(picture->camera.is_distorted());
  const ExtractionOptions options;
  compare_picture(model, *picture, options,
                  charts_of(recording.proposed_density().value_or(500), recording.proposed_max_texels().value_or(256)),
                  "workcell, picture 140, diamond, pyramid");
}

TEST_F(RecordingsOracle, KitchenPicture) {
  const std::filesystem::path directory = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::exists(directory / "rgb.txt")) GTEST_SKIP() << "no kitchen recording at " << directory;
  Recording recording = Recording::open(directory);
  const PolygonModel model = import_model(directory / "scene_5k.ply", recording.import_options());
  const std::optional<CameraFrame> picture = recording.read_frame(0, 300, model);
  ASSERT_TRUE(picture.has_value());
  ExtractionOptions options;
  options.artefacts = ArtefactSuppression::alternating;
  options.passes = 2;
  compare_picture(model, *picture, options, charts_of(200, 256), "kitchen, picture 300, alternating, pyramid");
}

}  // namespace
}  // namespace foreview::oracle
