#include "foreview/gpu/per_polygon/per_polygon_extraction.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>

#include "gpu/gl_test_fixture.h"
#include "oracle/comparison.h"
#include "oracle/random_scene.h"

namespace foreview::oracle {
namespace {

ChartOptions small_charts(double texels_per_metre = 80, int max_texels = 64) {
  ChartOptions options;
  options.texels_per_metre = texels_per_metre;
  options.max_texels = max_texels;
  options.page_size = 512;
  options.group_polygons = false;
  return options;
}

/// The pipeline under test with a store of its own.
struct Pipeline {
  TextureStore store;
  PerPolygonExtraction extraction;
  Pipeline(const PolygonModel& model, const ChartOptions& charts, const ExtractionOptions& options)
      : store(model, lay_out_charts(model, charts)), extraction(store, charts, options) {}
};

using PerPolygonOracle = GlTest;

struct Variant {
  ArtefactSuppression artefacts = ArtefactSuppression::none;
  int passes = 0;
  double alpha_c = 3.5;
  HoleFilling fill = HoleFilling::pyramid;
  int small_texture = 12;
  DistortionModel distortion = DistortionModel::none;
  bool backdrop = false;
  Pose world_from_scene = {};  ///< moves all of it, camera included
  unsigned seed = 1;
};

/// One picture onto empty textures, every polygon. Returns how many pixels of the undistorted picture are unusable.
std::ptrdiff_t compare_first_picture(const Variant& variant, const ChartOptions& charts, const std::string& what) {
  RandomScene scene = random_scene(variant.seed, variant.distortion, variant.backdrop);
  scene.frame.state.world_from_camera = variant.world_from_scene * scene.frame.state.world_from_camera;
  for (Pose& pose : scene.frame.state.world_from_part) pose = variant.world_from_scene * pose;
  ExtractionOptions options;
  options.artefacts = variant.artefacts;
  options.passes = variant.passes;
  options.alpha_c = variant.alpha_c;
  options.fill = variant.fill;
  options.small_texture = variant.small_texture;
  Pipeline gl(scene.model, charts, options);
  Comparison comparison(scene.model, options, charts);
  const PreparedFrame frame = comparison.oracle().prepare(scene.frame);
  comparison.add_undistorted(gl.extraction.undistorted(scene.frame), frame);
  for (std::size_t i = 0; i < scene.model.polygons().size(); ++i) {
    const auto& projected = project(scene.model, i, scene.frame.camera, scene.frame.state, options.near_plane);
    if (skip_reason(projected) != Skip::none) continue;
    comparison.add_polygon(gl.extraction.inspect(scene.frame, static_cast<std::uint32_t>(i)), frame, i);
  }
  EXPECT_GE(comparison.polygons(), 6u) << "the scene must test something";
  EXPECT_GE(comparison.texels_compared(), 100u);
  comparison.expect_agreement(what);
  return std::count(frame.picture.usable.values.begin(), frame.picture.usable.values.end(), 0);
}

TEST_F(PerPolygonOracle, WithoutSuppression) {
  compare_first_picture({.artefacts = ArtefactSuppression::none, .seed = 11}, small_charts(), "none");
  compare_first_picture(
      {.artefacts = ArtefactSuppression::none, .fill = HoleFilling::none, .backdrop = true, .seed = 12},
      small_charts(200, 100), "none, backdrop, 200 texels/m, r_max 100");
  compare_first_picture({.artefacts = ArtefactSuppression::none, .fill = HoleFilling::pyramid, .seed = 13},
                        small_charts(200, 100), "none, r_max 100");
  compare_first_picture({.artefacts = ArtefactSuppression::none, .fill = HoleFilling::none, .seed = 14}, small_charts(),
                        "none, holes left open");
}

TEST_F(PerPolygonOracle, Diamond) {
  for (const int passes : {1, 2, 5}) {
    compare_first_picture({.artefacts = ArtefactSuppression::diamond,
                           .passes = passes,
                           .fill = passes == 2 ? HoleFilling::iterative : HoleFilling::pyramid,
                           .seed = 20 + static_cast<unsigned>(passes)},
                          small_charts(), "diamond, passes " + std::to_string(passes));
  }
  compare_first_picture(
      {.artefacts = ArtefactSuppression::diamond, .passes = 3, .alpha_c = 3.0, .small_texture = 0, .seed = 27},
      small_charts(), "diamond, alpha_c 3, none exempt");
  compare_first_picture(
      {.artefacts = ArtefactSuppression::diamond, .passes = 3, .alpha_c = 3.87, .small_texture = 40, .seed = 28},
      small_charts(), "diamond, alpha_c 3.87, many exempt");
}

TEST_F(PerPolygonOracle, Alternating) {
  for (const int passes : {1, 2, 3}) {
    compare_first_picture({.artefacts = ArtefactSuppression::alternating,
                           .passes = passes,
                           .fill = passes == 2 ? HoleFilling::iterative : HoleFilling::pyramid,
                           .seed = 30 + static_cast<unsigned>(passes)},
                          small_charts(), "alternating, passes " + std::to_string(passes));
  }
}

TEST_F(PerPolygonOracle, Progressive) {
  for (const int passes : {1, 2, 4}) {
    compare_first_picture({.artefacts = ArtefactSuppression::progressive,
                           .passes = passes,
                           .fill = passes == 4 ? HoleFilling::iterative : HoleFilling::pyramid,
                           .seed = 40 + static_cast<unsigned>(passes)},
                          small_charts(), "progressive, passes " + std::to_string(passes));
  }
}

TEST_F(PerPolygonOracle, DistortedPictures) {
  std::ptrdiff_t all_usable = 0, some_unusable = 0;
  for (unsigned seed = 51; seed < 57; ++seed) {
    const std::ptrdiff_t unusable = compare_first_picture({.artefacts = ArtefactSuppression::diamond,
                                                           .passes = 2,
                                                           .distortion = DistortionModel::plumb_bob,
                                                           .backdrop = seed % 2 == 0,
                                                           .seed = seed},
                                                          small_charts(), "plumb_bob " + std::to_string(seed));
    ++(unusable > 100 ? some_unusable : all_usable);
  }
  EXPECT_GT(all_usable, 0) << "no barrel lens among them";
  EXPECT_GT(some_unusable, 0) << "no pincushion lens among them";
  compare_first_picture({.artefacts = ArtefactSuppression::alternating,
                         .passes = 1,
                         .distortion = DistortionModel::fisheye,
                         .backdrop = true,
                         .seed = 57},
                        small_charts(), "fisheye");
}

TEST_F(PerPolygonOracle, CoarseAndFineTextures) {
  compare_first_picture({.artefacts = ArtefactSuppression::diamond, .passes = 1, .seed = 61}, small_charts(8, 16),
                        "8 texels/m: many pixels a texel");
  compare_first_picture({.artefacts = ArtefactSuppression::diamond, .passes = 1, .seed = 62}, small_charts(600, 256),
                        "600 texels/m: many texels a pixel");
}

TEST_F(PerPolygonOracle, FarFromTheWorldsOrigin) {
  const Pose far{glm::angleAxis(2.0, glm::normalize(glm::dvec3(1, -2, 0.5))), glm::dvec3(70'000, -30'000, 900)};
  compare_first_picture({.artefacts = ArtefactSuppression::diamond, .passes = 3, .world_from_scene = far, .seed = 65},
                        small_charts(), "76 km from the world's origin");
}

TEST_F(PerPolygonOracle, CountsWhatItSkips) {
  for (const unsigned seed : {71U, 72U, 73U}) {
    const RandomScene scene = random_scene(seed, DistortionModel::plumb_bob, true);
    ExtractionOptions options;
    Pipeline gl(scene.model, small_charts(), options);
    const ExtractionStatistics statistics = gl.extraction.extract(scene.frame);
    std::map<Skip, std::size_t> expected;
    std::size_t exempt = 0;
    for (std::size_t i = 0; i < scene.model.polygons().size(); ++i) {
      const ProjectedPolygon p = project(scene.model, i, scene.frame.camera, scene.frame.state, options.near_plane);
      const Skip reason = skip_reason(p);
      ++expected[reason];
      if (reason == Skip::none && std::min(p.box.width(), p.box.height()) < options.small_texture) ++exempt;
    }
    EXPECT_EQ(statistics.polygons_visible, expected[Skip::none]);
    EXPECT_EQ(statistics.polygons_skipped_back_face, expected[Skip::back_face]);
    EXPECT_EQ(statistics.polygons_skipped_outside, expected[Skip::outside]);
    EXPECT_EQ(statistics.polygons_skipped_too_small, expected[Skip::too_small]);
    EXPECT_EQ(statistics.polygons_exempt_small, exempt);
  }
}

/// Three pictures, the last of them late: what GL holds after each must follow from what it held before.
TEST_F(PerPolygonOracle, FusionOfSeveralPicturesAndTheCharts) {
  const RandomScene scene = random_scene(81, DistortionModel::plumb_bob, true);
  const ChartOptions charts = small_charts();
  ExtractionOptions options;
  options.passes = 2;
  Pipeline gl(scene.model, charts, options);
  Comparison comparison(scene.model, options, charts);
  const std::vector<CameraFrame> pictures{scene.frame, moved(scene, 82, Timestamp{3'000'000}),
                                          moved(scene, 83, Timestamp{2'000'000})};
  std::map<std::size_t, Texture> textures;
  std::map<std::size_t, Timestamp> newest;
  for (const CameraFrame& picture : pictures) {
    const PreparedFrame frame = comparison.oracle().prepare(picture);
    std::map<std::size_t, PerPolygonExtraction::Intermediate> results;
    for (std::size_t i = 0; i < scene.model.polygons().size(); ++i) {
      const ProjectedPolygon projected = project(scene.model, i, picture.camera, picture.state, options.near_plane);
      if (skip_reason(projected) != Skip::none) continue;
      results[i] = gl.extraction.inspect(picture, static_cast<std::uint32_t>(i));
      const auto before = textures.find(i);
      if (before == textures.end()) {
        comparison.add_polygon(results[i], frame, i);
      } else {
        comparison.add_polygon(results[i], frame, i, before->second, picture.state.stamp < newest[i]);
      }
    }
    (void)gl.extraction.extract(picture);
    const std::vector<cv::Mat> pages = gl.store.read_pages();
    const std::vector<TextureStore::PolygonState> states = gl.store.read_polygon_states();
    for (const auto& [polygon, result] : results) {
      const Chart& chart = gl.store.layout().charts[polygon];
      comparison.add_chart(pages[chart.page], chart, polygon, result);
      const Texture fused = texture_of(result.fused);
      const bool any = std::count(fused.valid.values.begin(), fused.valid.values.end(), 1) > 0;
      EXPECT_EQ(states[polygon].seen == 1, any) << polygon;
      if (any) {
        Texture top = fused;
        while (top.width() > 1 || top.height() > 1) top = pull(top);
        EXPECT_NEAR(states[polygon].blue * 255, top.colour.at(0, 0).x, 2) << polygon;
        EXPECT_NEAR(states[polygon].green * 255, top.colour.at(0, 0).y, 2) << polygon;
        EXPECT_NEAR(states[polygon].red * 255, top.colour.at(0, 0).z, 2) << polygon;
      }
      textures[polygon] = fused;
      newest[polygon] = std::max(newest[polygon], picture.state.stamp);
    }
  }
  comparison.expect_agreement("three pictures, the third late");
}

TEST_F(PerPolygonOracle, IterativeFillingDoesNotDependOnTheOcclusionQuery) {
  const RandomScene scene = random_scene(91, DistortionModel::none, false);
  ExtractionOptions options;
  options.fill = HoleFilling::iterative;
  Pipeline with_query(scene.model, small_charts(40, 32), options);
  options.occlusion_query = false;
  Pipeline without(scene.model, small_charts(40, 32), options);
  (void)with_query.extraction.extract(scene.frame);
  (void)without.extraction.extract(scene.frame);
  const std::vector<cv::Mat> a = with_query.store.read_pages(), b = without.store.read_pages();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(std::equal(a[i].begin<cv::Vec4b>(), a[i].end<cv::Vec4b>(), b[i].begin<cv::Vec4b>()));
  }
}

}  // namespace
}  // namespace foreview::oracle
