// The method of 2005 on small scenes whose result can be told in advance. The systematic comparison is the oracle's.
#include <algorithm>
#include <set>

#include "gpu/extraction_scene.h"

namespace foreview {
namespace {

constexpr float kOutside = 31.0F / 32.0F;

TEST_F(ExtractionTest, SquareFacingTheCameraGetsThePicturesColours) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  pipeline_->set_counting(true);
  const CameraFrame picture = frame();
  const ExtractionStatistics statistics = pipeline_->extract(picture);
  EXPECT_EQ(statistics.polygons_visible, 1U);
  // The last row's and column's samples reach a pixel beyond the square, where nothing is.
  EXPECT_EQ(statistics.texels_observed, 63U * 63U);
  EXPECT_EQ(statistics.total_ms, 0);

  const PerPolygonExtraction::Intermediate result = pipeline_->inspect(picture, 0);
  ASSERT_EQ(result.fused.size(), cv::Size(64, 64));
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const auto& texel = result.fused.at<cv::Vec4b>(y, x);
      const glm::dvec2 pixel = pixel_of_texel(0, x, y, result.fused);
      ASSERT_EQ(texel[3], pixel.x < 111 && pixel.y < 91 ? 255 : 0);
      if (texel[3] == 255)
        expect_colour(texel, gradient(pixel.x, pixel.y), 1.01, "texel " + std::to_string(x) + ", " + std::to_string(y));
    }
  }

  // The chart holds the same, and says that it was observed.
  const cv::Mat page = store_->read_pages().at(0);
  const Chart& chart = store_->layout().charts[0];
  for (int y = chart.origin.y + kChartGutter; y < chart.origin.y + kChartGutter + chart.inner.y; ++y) {
    for (int x = chart.origin.x + kChartGutter; x < chart.origin.x + kChartGutter + chart.inner.x; ++x) {
      const glm::dvec2 pixel = camera_.pixel_from_camera(chart.part_from_texel({x + 0.5, y + 0.5}));
      if (pixel.x > 111 || pixel.y > 91) continue;
      const auto& texel = page.at<cv::Vec4b>(y, x);
      ASSERT_EQ(texel[3], 255);
      expect_colour(texel, gradient(pixel.x, pixel.y), 1.51, "chart");
    }
  }
  const TextureStore::PolygonState state = store_->read_polygon_states().at(0);
  EXPECT_EQ(state.seen, 1);
  const cv::Vec3d mean = gradient(80.3, 60.2);
  EXPECT_NEAR(state.blue * 255, mean[0], 1);
  EXPECT_NEAR(state.green * 255, mean[1], 1);
  EXPECT_NEAR(state.red * 255, mean[2], 1);
}

TEST_F(ExtractionTest, SlantedPolygonIsCorrectInPerspective) {
  RawMesh mesh;
  mesh.vertices = {{-0.4, -0.3, 0.8}, {-0.4, 0.3, 0.8}, {0.5, 0.3, 1.6}, {0.5, -0.3, 1.6}};
  mesh.faces = {{0, 1, 2, 3}};
  build(mesh);
  const PerPolygonExtraction::Intermediate result = pipeline_->inspect(frame(), 0);
  int valid = 0;
  for (int y = 0; y < result.fused.rows; ++y) {
    for (int x = 0; x < result.fused.cols; ++x) {
      const auto& texel = result.fused.at<cv::Vec4b>(y, x);
      if (texel[3] == 0) continue;
      ++valid;
      const glm::dvec2 pixel = pixel_of_texel(0, x, y, result.fused);
      expect_colour(texel, gradient(pixel.x, pixel.y), 1.5, "texel");
    }
  }
  EXPECT_GT(valid, static_cast<int>(result.fused.total()) * 9 / 10);
}

TEST_F(ExtractionTest, MinifiedTexelsTakeTheirWholeFootprint) {
  // 25 texels per metre: four pixels a texel. Stripes of one pixel in four must come out as their mean.
  charts_.texels_per_metre = 25;
  camera_.principal_point = {80, 60};
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  const auto stripes = [](double u, double) {
    const double grey = static_cast<int>(u) % 4 == 0 ? 200 : 40;
    return cv::Vec3d(grey, grey, grey);
  };
  const PerPolygonExtraction::Intermediate result = pipeline_->inspect(frame(stripes), 0);
  ASSERT_EQ(result.fused.size(), cv::Size(16, 16));
  for (const auto& texel : cv::Mat_<cv::Vec4b>(result.fused)) {
    if (texel[3] == 255) {
      EXPECT_NEAR(texel[0], 80, 1);
    }
  }
}

TEST_F(ExtractionTest, OccluderMasksWhatItHides) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  add_quad(mesh, -0.05, -0.05, 0.05, 0.05, 0.5);  // pixels 70.3..90.3, 50.2..70.2
  build(mesh);
  options_.artefacts = ArtefactSuppression::none;
  build(mesh);
  const std::uint32_t behind = polygon_at({0, 0, 1});
  const auto result = pipeline_->inspect(frame(), behind);
  EXPECT_EQ(count_zeros(result.box_alpha_before), 20 * 20);
  for (int y = 0; y < result.box_alpha_before.rows; ++y) {
    for (int x = 0; x < result.box_alpha_before.cols; ++x) {
      const double u = result.box_x + x + 0.5, v = result.box_y + y + 0.5;
      const bool hidden = u > 70.3 && u < 90.3 && v > 50.2 && v < 70.2;
      const bool inside = u > 48.3 && u < 112.3 && v > 28.2 && v < 92.2;
      EXPECT_EQ(result.box_alpha_before.at<float>(y, x), hidden ? 0 : inside ? 1 : kOutside) << u << ", " << v;
    }
  }
  EXPECT_EQ(cv::norm(result.box_alpha_before, result.box_alpha_after, cv::NORM_INF), 0);
  // A texel is valid only if all four pixels of its sample are.
  for (int y = 0; y < result.fused.rows; ++y) {
    for (int x = 0; x < result.fused.cols; ++x) {
      const glm::dvec2 pixel = pixel_of_texel(behind, x, y, result.fused);
      const bool touches = pixel.x > 69.5 && pixel.x < 90.5 && pixel.y > 49.5 && pixel.y < 70.5;
      const bool safe = pixel.x > 50 && pixel.x < 110 && pixel.y > 30 && pixel.y < 90 &&
                        !(pixel.x > 69 && pixel.x < 91 && pixel.y > 49 && pixel.y < 71);
      const int alpha = result.fused.at<cv::Vec4b>(y, x)[3];
      if (touches || safe) {
        EXPECT_EQ(alpha, safe ? 255 : 0) << pixel.x << ", " << pixel.y;
      }
    }
  }
}

TEST_F(ExtractionTest, BandAlongTheOutlineIsJudged) {
  const auto alpha_beside = [this](const RawMesh& mesh, int pixels_left_of_edge) {
    build(mesh);
    const auto result = pipeline_->inspect(frame(), polygon_at({0, 0, 1}));
    // The left edge lies at u = 48.3; pixel 48's centre is the first one inside.
    return result.box_alpha_before.at<float>(60 - result.box_y, 48 - pixels_left_of_edge - result.box_x);
  };
  RawMesh alone;
  add_quad(alone, -0.32, -0.32, 0.32, 0.32, 1);
  EXPECT_EQ(alpha_beside(alone, 0), 1);
  EXPECT_EQ(alpha_beside(alone, 1), kOutside);  // nothing there

  RawMesh with_wall = alone;
  add_quad(with_wall, -3, -3, 3, 3, 2);
  EXPECT_EQ(alpha_beside(with_wall, 1), kOutside);  // far behind

  RawMesh with_neighbour = alone;
  with_neighbour.vertices.insert(with_neighbour.vertices.end(), {{-0.6, -0.32, 1.3}, {-0.6, 0.32, 1.3}});
  with_neighbour.faces.push_back({4, 5, 1, 0});
  EXPECT_EQ(alpha_beside(with_neighbour, 1), 1);
  EXPECT_EQ(alpha_beside(with_neighbour, 2), 1);
  EXPECT_EQ(alpha_beside(with_neighbour, 3), kOutside);  // 2.8 pixels: beyond the band

  RawMesh with_plane = alone;  // same plane, but no shared edge
  add_quad(with_plane, -0.6, -0.4, -0.321, 0.4, 1);
  EXPECT_EQ(alpha_beside(with_plane, 2), 1);

  RawMesh with_occluder = alone;
  add_quad(with_occluder, -0.4, -0.32, -0.161, 0.32, 0.5);  // right edge at u = 48.1
  EXPECT_EQ(alpha_beside(with_occluder, 1), 0);
  EXPECT_EQ(alpha_beside(with_occluder, 0), 1);
}

/// One pixel of a square is hidden, by a quad a little larger than a pixel: (83, 62).
class SuppressionTest : public ExtractionTest {
 protected:
  SuppressionTest() {
    add_quad(mesh_, -0.32, -0.32, 0.32, 0.32, 1);
    const double x = 83.5 - 80.3, y = 62.5 - 60.2;
    add_quad(mesh_, (x - 0.4) / 200, (y - 0.4) / 200, (x + 0.4) / 200, (y + 0.4) / 200, 0.5);
  }
  cv::Mat alpha_after(ArtefactSuppression variant, int passes) {
    options_.artefacts = variant;
    options_.passes = passes;
    build(mesh_);
    result_ = pipeline_->inspect(frame(), polygon_at({0, 0, 1}));
    EXPECT_EQ(count_zeros(result_.box_alpha_before), 1);
    EXPECT_EQ(result_.box_alpha_before.at<float>(62 - result_.box_y, 83 - result_.box_x), 0);
    return result_.box_alpha_after;
  }
  /// What is not killed keeps its own alpha.
  void expect_survivors_unchanged() {
    cv::Mat difference = result_.box_alpha_before - result_.box_alpha_after;
    difference.setTo(0, result_.box_alpha_after == 0);
    EXPECT_EQ(cv::countNonZero(difference), 0);
  }
  cv::Rect zeros_box(const cv::Mat& alpha) const {
    std::vector<cv::Point> zeros;
    cv::findNonZero(alpha == 0, zeros);
    int x0 = alpha.cols, y0 = alpha.rows, x1 = -1, y1 = -1;
    for (const cv::Point& p : zeros) {
      x0 = std::min(x0, p.x);
      y0 = std::min(y0, p.y);
      x1 = std::max(x1, p.x);
      y1 = std::max(y1, p.y);
    }
    return {x0, y0, x1 - x0 + 1, y1 - y0 + 1};
  }
  RawMesh mesh_;
  PerPolygonExtraction::Intermediate result_;
};

TEST_F(SuppressionTest, DiamondsGrowByOneAPass) {
  for (const int passes : {0, 1, 3}) {
    const cv::Mat alpha = alpha_after(ArtefactSuppression::diamond, passes);
    for (int y = 0; y < alpha.rows; ++y) {
      for (int x = 0; x < alpha.cols; ++x) {
        const int distance = std::abs(x + result_.box_x - 83) + std::abs(y + result_.box_y - 62);
        EXPECT_EQ(alpha.at<float>(y, x) == 0, distance <= passes) << passes << " passes: " << x << ", " << y;
      }
    }
    expect_survivors_unchanged();
  }
}

TEST_F(SuppressionTest, AlternatingMakesFourByFourOfOne) {
  const cv::Mat once = alpha_after(ArtefactSuppression::alternating, 1);
  EXPECT_EQ(count_zeros(once), 16);
  EXPECT_EQ(zeros_box(once).size(), cv::Size(4, 4));
  EXPECT_TRUE(zeros_box(once).contains({83 - result_.box_x, 62 - result_.box_y}));
  expect_survivors_unchanged();
  // The four columns straddle three pairs; enlarging adds one on each side.
  const cv::Mat twice = alpha_after(ArtefactSuppression::alternating, 2);
  EXPECT_EQ(count_zeros(twice), 64);
  EXPECT_EQ(zeros_box(twice).size(), cv::Size(8, 8));
}

TEST_F(SuppressionTest, ProgressiveGrowsFaster) {
  const cv::Mat once = alpha_after(ArtefactSuppression::progressive, 1);
  EXPECT_EQ(count_zeros(once), 16);
  // One texel of a quarter's image: 2 + 2 of the half's, twice that + 2 of the whole.
  const cv::Mat twice = alpha_after(ArtefactSuppression::progressive, 2);
  EXPECT_EQ(count_zeros(twice), 100);
  EXPECT_EQ(zeros_box(twice).size(), cv::Size(10, 10));
  expect_survivors_unchanged();
  // Far more reductions than the box has: everything is gone, and nothing breaks.
  const cv::Mat all = alpha_after(ArtefactSuppression::progressive, 20);
  EXPECT_EQ(count_zeros(all), static_cast<int>(all.total()));
}

TEST_F(SuppressionTest, NoneKeepsAll) {
  EXPECT_EQ(count_zeros(alpha_after(ArtefactSuppression::none, 3)), 1);
}

TEST_F(SuppressionTest, SmallTexturesAreExempt) {
  options_.small_texture = 65;  // the square's box is 65 pixels: it does not lie on the grid
  EXPECT_EQ(count_zeros(alpha_after(ArtefactSuppression::diamond, 3)), 25);
  options_.small_texture = 66;
  EXPECT_EQ(count_zeros(alpha_after(ArtefactSuppression::diamond, 3)), 1);
  EXPECT_EQ(pipeline_->extract(frame()).polygons_exempt_small, 2U);
}

TEST_F(ExtractionTest, ConcaveCreaseKeepsItsTexels) {
  // A room's corner: floor and wall meet at y = 0.3, z = 2.
  RawMesh mesh;
  mesh.vertices = {{-0.6, -0.4, 2}, {-0.6, 0.3, 2}, {0.6, 0.3, 2}, {0.6, -0.4, 2}, {-0.6, 0.3, 1}, {0.6, 0.3, 1}};
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 5, 2}};
  build(mesh);
  for (const std::uint32_t polygon : {0U, 1U}) {
    const auto result = pipeline_->inspect(frame(), polygon);
    ASSERT_FALSE(result.box_alpha_after.empty());
    EXPECT_EQ(count_zeros(result.box_alpha_after), 0);
    EXPECT_GT(cv::countNonZero(result.box_alpha_after == 1), 500);
  }
}

TEST_F(ExtractionTest, NewestWinsAndLatePicturesOnlyFill) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  add_quad(mesh, -0.05, -0.05, 0.05, 0.05, 0.5);
  mesh.face_part = {0, 1};
  mesh.part_names = {"wall", "occluder"};
  build(mesh);
  const std::uint32_t wall = polygon_at({0, 0, 1});
  const auto values = [&](const CameraFrame& f) {
    pipeline_->extract(f);
    std::set<int> found;  // -1: not valid, which the square's rim is always
    const cv::Mat_<cv::Vec4b> fused = pipeline_->inspect(f, wall).fused;
    for (const cv::Vec4b& texel : fused) found.insert(texel[3] == 0 ? -1 : texel[0]);
    return found;
  };
  EXPECT_EQ(values(frame(plain(100), 1)), (std::set<int>{-1, 100}));
  EXPECT_EQ(values(frame(plain(150), 2)), (std::set<int>{-1, 150}));
  // Late, and seen whole because the occluder was elsewhere: only the hidden part takes it.
  CameraFrame late = frame(plain(50), 1.5);
  late.state.world_from_part[static_cast<std::size_t>(model_->part_index("occluder"))].translation = {5, 0, 0};
  EXPECT_EQ(values(late), (std::set<int>{-1, 50, 150}));
  // A newer one overwrites what the late one filled, where it sees it.
  CameraFrame newer = late;
  newer.state.stamp = Timestamp::from_seconds(3);
  newer.picture = frame(plain(220)).picture;
  EXPECT_EQ(values(newer), (std::set<int>{-1, 220}));
  pipeline_->clear();
  EXPECT_EQ(store_->count_observed_texels(), 0U);
  EXPECT_EQ(values(late), (std::set<int>{-1, 50}));
}

TEST_F(ExtractionTest, FillingUsesWhatIsValidAndKeepsIt) {
  // The left half is out of the picture; colours rise along u.
  RawMesh mesh;
  add_quad(mesh, -1.12, -0.32, -0.48, 0.32, 1);
  for (const HoleFilling fill : {HoleFilling::none, HoleFilling::pyramid, HoleFilling::iterative}) {
    options_.fill = fill;
    build(mesh);
    const auto result = pipeline_->inspect(frame(), 0);
    ASSERT_EQ(result.filled.size(), result.fused.size());
    int holes = 0, least = 255, greatest = 0;
    for (int y = 0; y < result.fused.rows; ++y) {
      for (int x = 0; x < result.fused.cols; ++x) {
        const auto &fused = result.fused.at<cv::Vec4b>(y, x), &filled = result.filled.at<cv::Vec4b>(y, x);
        EXPECT_EQ(filled[3], fused[3]);
        if (fused[3] == 255) {
          EXPECT_EQ(filled, fused);
          continue;
        }
        ++holes;
        least = std::min<int>(least, filled[0]);
        greatest = std::max<int>(greatest, filled[0]);
      }
    }
    EXPECT_GT(holes, 2000);
    if (fill == HoleFilling::none) {
      EXPECT_EQ(least, 128);
      EXPECT_EQ(greatest, 128);
    } else {
      // Between the colours at the picture's left edge (20) and at the square's right one (52).
      EXPECT_GE(least, 20);
      EXPECT_LE(greatest, 52);
      EXPECT_LT(least, 45);
    }
  }
}

TEST_F(ExtractionTest, OneValidTexelFillsAll) {
  // Everything but a few pixels is hidden by a frame of four quads.
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  add_quad(mesh, -0.3, -0.3, 0.015, 0.3, 0.5);
  add_quad(mesh, 0.035, -0.3, 0.3, 0.3, 0.5);
  add_quad(mesh, 0.015, -0.3, 0.035, -0.02, 0.5);
  add_quad(mesh, 0.015, 0.005, 0.035, 0.3, 0.5);
  options_.artefacts = ArtefactSuppression::none;
  std::vector<cv::Mat> iterative;
  for (const auto& [fill, query] : {std::pair{HoleFilling::pyramid, true}, std::pair{HoleFilling::iterative, true},
                                    std::pair{HoleFilling::iterative, false}}) {
    options_.fill = fill;
    options_.occlusion_query = query;
    build(mesh);
    const std::uint32_t wall = polygon_at({0, 0, 1});
    const auto result = pipeline_->inspect(frame(plain(77)), wall);
    const cv::Mat_<cv::Vec4b> fused = result.fused, filled = result.filled;
    const auto valid = std::count_if(fused.begin(), fused.end(), [](const cv::Vec4b& t) { return t[3] == 255; });
    EXPECT_GT(valid, 0);
    EXPECT_LT(valid, 30);
    for (const cv::Vec4b& texel : filled) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(texel[c], 77);
    }
    if (fill == HoleFilling::iterative) iterative.push_back(pipeline_->inspect(frame(), wall).filled);
  }
  EXPECT_EQ(cv::norm(iterative[0], iterative[1], cv::NORM_INF), 0);
}

TEST_F(ExtractionTest, FillingWideHolesDoesNotDarken) {
  // Some 190 texels from the rim: what is lost by rounding in one pass would add up.
  charts_.texels_per_metre = 400;
  RawMesh mesh;
  add_quad(mesh, -1.28, -0.32, -0.64, 0.32, 1);
  const auto rising = [](double, double v) {
    const double grey = 60 + 2 * (v - 28);
    return cv::Vec3d(grey, grey, grey);
  };
  for (const HoleFilling fill : {HoleFilling::pyramid, HoleFilling::iterative}) {
    options_.fill = fill;
    build(mesh);
    const auto result = pipeline_->inspect(frame(rising), 0);
    ASSERT_EQ(result.filled.size(), cv::Size(256, 256));
    cv::Mat channels[4];
    cv::split(result.filled, channels);
    const cv::Mat hole = channels[3] == 0;
    ASSERT_GT(cv::countNonZero(hole), 40000);
    // The colours rise alike above and below the middle, so filling must keep their mean, but for the last rows, which
    // are not valid: 0.6. Half floats lost 1.7 on the way.
    EXPECT_NEAR(cv::mean(channels[0], hole)[0], cv::mean(channels[0], channels[3])[0], 0.8);
  }
}

TEST_F(ExtractionTest, LargeTexturesFillLikeSmallOnes) {
  // 256 x 256 goes through the pyramid's dispatches, 32 x 32 through one work group: the same holes in the same place.
  cv::Mat means[2];
  for (const int size : {256, 32}) {
    charts_.max_texels = size;
    charts_.texels_per_metre = 1000;
    RawMesh mesh;
    add_quad(mesh, -1.12, -0.32, -0.48, 0.32, 1);
    build(mesh);
    const auto result = pipeline_->inspect(frame(), 0);
    ASSERT_EQ(result.filled.size(), cv::Size(size, size));
    cv::Mat& mean = means[size == 256 ? 0 : 1];
    mean.create(8, 8, CV_8UC4);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const cv::Scalar m = cv::mean(result.filled(cv::Rect(x * size / 8, y * size / 8, size / 8, size / 8)));
        mean.at<cv::Vec4b>(y, x) = cv::Vec4b(cv::saturate_cast<uchar>(m[0]), cv::saturate_cast<uchar>(m[1]),
                                             cv::saturate_cast<uchar>(m[2]), 0);
      }
    }
  }
  EXPECT_LE(cv::norm(means[0], means[1], cv::NORM_INF), 3);
}

TEST_F(ExtractionTest, NothingValidLeavesGreyAndNoState) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  add_quad(mesh, -0.5, -0.5, 0.5, 0.5, 0.9);
  for (const HoleFilling fill : {HoleFilling::none, HoleFilling::pyramid, HoleFilling::iterative}) {
    options_.fill = fill;
    build(mesh);
    const std::uint32_t hidden = polygon_at({0, 0, 1});
    pipeline_->extract(frame());
    const auto result = pipeline_->inspect(frame(), hidden);
    for (const cv::Vec4b& texel : cv::Mat_<cv::Vec4b>(result.filled)) ASSERT_EQ(texel, cv::Vec4b(128, 128, 128, 0));
    EXPECT_NE(store_->read_polygon_states()[hidden].seen, 1);
  }
}

TEST_F(ExtractionTest, NeverSeenPolygonsTakeTheirNeighboursColour) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  // Its back to the camera, sharing an edge; a further one beyond that.
  mesh.vertices.insert(mesh.vertices.end(), {{0.32, -0.32, 1.5}, {0.32, 0.32, 1.5}, {0, -0.32, 2}, {0, 0.32, 2}});
  mesh.faces.push_back({3, 2, 5, 4});
  mesh.faces.push_back({4, 5, 7, 6});
  build(mesh);
  const ExtractionStatistics statistics = pipeline_->extract(frame(plain(90)));
  EXPECT_EQ(statistics.polygons_visible, 1U);
  EXPECT_EQ(statistics.polygons_skipped_back_face, 2U);
  const std::uint32_t seen = polygon_at({0, 0, 1});
  const auto states = store_->read_polygon_states();
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(states[i].seen, i == seen ? 1.0F : 0.5F);
    EXPECT_NEAR(states[i].green * 255, 90, 1);
  }
}

TEST_F(ExtractionTest, PartsAreWhereThePictureHasThem) {
  RawMesh mesh;
  add_quad(mesh, -0.1, -0.1, 0.1, 0.1, 1);
  mesh.face_part = {0};
  mesh.part_names = {"thing"};
  build(mesh);
  CameraFrame moved = frame();
  // A quarter turn about the optical axis and a step to the right; the world is turned about with the camera.
  Pose& part = moved.state.world_from_part[0];
  part.rotation = glm::angleAxis(std::acos(-1.0) / 2, glm::dvec3(0, 0, 1));
  part.translation = {0.3, 0, 0};
  const Pose elsewhere{glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3))), {1e6, -2e6, 3e5}};
  part = elsewhere * part;
  moved.state.world_from_camera = elsewhere;
  const auto result = pipeline_->inspect(moved, 0);
  const PolygonFrame plane = polygon_frame(*model_, 0);
  const Pose camera_from_part = elsewhere.inverse() * part;
  int valid = 0;
  for (int y = 0; y < result.fused.rows; ++y) {
    for (int x = 0; x < result.fused.cols; ++x) {
      const auto& texel = result.fused.at<cv::Vec4b>(y, x);
      if (texel[3] == 0) continue;
      ++valid;
      const glm::dvec2 q =
          glm::dvec2(x + 0.5, y + 0.5) / glm::dvec2(result.fused.cols, result.fused.rows) * plane.extent;
      const glm::dvec2 pixel = camera_.pixel_from_camera(camera_from_part * plane.part_from_plane(q));
      expect_colour(texel, gradient(pixel.x, pixel.y), 1.01, "texel");
    }
  }
  EXPECT_GT(valid, 800);
}

TEST_F(ExtractionTest, PolygonsCrossTheCameraPlane) {
  // A floor from 2 m behind the camera to 3 m before it, and a wall through the camera's position.
  RawMesh mesh;
  mesh.vertices = {{-1, 0.4, -2}, {1, 0.4, -2}, {1, 0.4, 3}, {-1, 0.4, 3}};
  mesh.faces = {{0, 1, 2, 3}};
  build(mesh);
  const ExtractionStatistics statistics = pipeline_->extract(frame());
  EXPECT_EQ(statistics.polygons_visible, 1U);
  const auto result = pipeline_->inspect(frame(), 0);
  const PolygonFrame plane = polygon_frame(*model_, 0);
  int valid = 0;
  for (int y = 0; y < result.fused.rows; ++y) {
    for (int x = 0; x < result.fused.cols; ++x) {
      const auto& texel = result.fused.at<cv::Vec4b>(y, x);
      const glm::dvec2 q = glm::dvec2(x + 0.5, y + 0.5) / glm::dvec2(result.fused.cols, result.fused.rows);
      const glm::dvec3 p = plane.part_from_plane(q * plane.extent);
      if (texel[3] == 0) continue;
      ++valid;
      ASSERT_GT(p.z, options_.near_plane);
      const glm::dvec2 pixel = camera_.pixel_from_camera(p);
      if (p.z > 0.9 && p.z < 2) expect_colour(texel, gradient(pixel.x, pixel.y), 2, "texel");
    }
  }
  EXPECT_GT(valid, 1000);
}

TEST_F(ExtractionTest, OddSituationsAreHandled) {
  // Camera inside a wall's plane, wholly behind, beside, and a sliver: nothing to take, each counted once.
  RawMesh mesh;
  mesh.vertices = {{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}};
  mesh.faces = {{0, 1, 2, 3}};
  add_quad(mesh, -0.3, -0.3, 0.3, 0.3, -1);
  add_quad(mesh, 5, -0.3, 6, 0.3, 1);
  add_quad(mesh, 0.1, 0.1, 0.10005, 0.2, 1);
  build(mesh);
  const ExtractionStatistics statistics = pipeline_->extract(frame());
  EXPECT_EQ(statistics.polygons_visible, 0U);
  EXPECT_EQ(statistics.polygons_skipped_back_face, 2U);
  EXPECT_EQ(statistics.polygons_skipped_outside, 1U);
  EXPECT_EQ(statistics.polygons_skipped_too_small, 1U);
  EXPECT_EQ(store_->count_observed_texels(), 0U);
}

TEST_F(ExtractionTest, TinyTexturesAndPicturesAreHandled) {
  charts_.texels_per_metre = 1;
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);  // 1 x 1 texel
  add_quad(mesh, -4, 0.4, 4, 0.5, 1);           // 8 x 1
  add_quad(mesh, -0.5, -4, -0.4, 4, 1);         // 1 x 8, or turned
  build(mesh);
  pipeline_->extract(frame());
  const auto small = pipeline_->inspect(frame(), polygon_at({0, 0, 1}));
  ASSERT_EQ(small.fused.size(), cv::Size(1, 1));
  EXPECT_EQ(small.fused.at<cv::Vec4b>(0, 0)[3], 255);
  const auto strip = pipeline_->inspect(frame(), polygon_at({0, 0.45, 1}));
  EXPECT_EQ(strip.fused.total(), 8U);

  camera_.width = camera_.height = 1;
  camera_.focal_length = {1, 1};
  camera_.principal_point = {0.5, 0.5};
  const ExtractionStatistics statistics = pipeline_->extract(frame());
  EXPECT_GE(statistics.polygons_visible, 1U);
}

TEST_F(ExtractionTest, SameInputSamePictureAndNoNewObjects) {
  RawMesh mesh;
  add_quad(mesh, -0.6, -0.5, 0.6, 0.5, 1);
  add_quad(mesh, -0.05, -0.05, 0.25, 0.05, 0.5);
  add_quad(mesh, 0.2, -0.3, 0.3, 0.3, 0.8);
  build(mesh);
  const auto noise = [](double u, double v) {
    const int n = static_cast<int>(u * 7919 + v * 104729);
    return cv::Vec3d(n % 251, n % 239, n % 241);
  };
  pipeline_->extract(frame(noise, 1));
  const long objects = live_gl_objects();
  pipeline_->extract(frame(noise, 2));
  const cv::Mat first = store_->read_pages()[0];
  EXPECT_EQ(live_gl_objects(), objects);
  pipeline_->clear();
  pipeline_->extract(frame(noise, 1));
  pipeline_->extract(frame(noise, 2));
  EXPECT_EQ(cv::norm(first, store_->read_pages()[0], cv::NORM_INF), 0);
  EXPECT_EQ(live_gl_objects(), objects);
}

TEST_F(ExtractionTest, AdoptsWhatTheChartsHold) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  add_quad(mesh, -0.05, -0.05, 0.05, 0.05, 0.5);
  build(mesh);
  const std::uint32_t wall = polygon_at({0, 0, 1});
  pipeline_->extract(frame(gradient, 5));
  const cv::Mat before = pipeline_->inspect(frame(gradient, 5), wall).fused;

  PerPolygonExtraction other(*store_, charts_, options_);
  other.adopt_store();
  // A picture without the wall in it leaves the texture as it was adopted.
  CameraFrame away = frame(gradient, 6);
  away.state.world_from_camera.translation = {0, 0, 50};
  const cv::Mat adopted = other.inspect(away, wall).fused;
  ASSERT_EQ(adopted.size(), before.size());
  int different = 0;
  for (int y = 0; y < before.rows; ++y) {
    for (int x = 0; x < before.cols; ++x) {
      const auto &a = before.at<cv::Vec4b>(y, x), &b = adopted.at<cv::Vec4b>(y, x);
      if (a[3] != b[3]) {
        ++different;
      } else if (a[3] == 255) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 2);
      }
    }
  }
  EXPECT_LE(different, 80);  // along the hole's rim, where the two grids do not meet
  // Any picture is newer than what was loaded.
  other.extract(frame(plain(33), 1));
  const cv::Mat_<cv::Vec4b> fused = other.inspect(frame(plain(33), 1), wall).fused;
  EXPECT_GT(std::count_if(fused.begin(), fused.end(), [](const cv::Vec4b& t) { return t[0] == 33; }), 2000);
}

TEST_F(ExtractionTest, UndistortsBothLensModels) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  const auto check_model = [this](DistortionModel model, const std::array<double, 8>& coefficients) {
    camera_.distortion_model = model;
    camera_.distortion = coefficients;
    const CameraFrame picture = frame();
    const cv::Mat result = pipeline_->undistorted(picture);
    ASSERT_EQ(result.size(), picture.picture.size());
    const CameraModel straight = camera_.undistorted();
    int usable = 0;
    for (int y = 0; y < result.rows; ++y) {
      for (int x = 0; x < result.cols; ++x) {
        const glm::dvec2 lens = camera_.pixel_from_camera(straight.ray_from_pixel({x + 0.5, y + 0.5}));
        const auto& texel = result.at<cv::Vec4b>(y, x);
        const double room =
            std::min({lens.x - 0.5, lens.y - 0.5, result.cols - 0.5 - lens.x, result.rows - 0.5 - lens.y});
        if (room > 0.01) {
          ++usable;
          EXPECT_EQ(texel[3], 255);
          expect_colour(texel, gradient(lens.x, lens.y), 1.01, "pixel");
        } else if (room < -0.01) {
          EXPECT_EQ(texel[3], 0);
        }
      }
    }
    EXPECT_GT(usable, 10000);
    EXPECT_LT(usable, 160 * 120);
  };
  check_model(DistortionModel::plumb_bob, {0.2, -0.1, 0.01, -0.02, 0.02, 0.1, 0.02, -0.01});
  check_model(DistortionModel::fisheye, {0.6, 0.05, -0.01, 0.002, 0, 0, 0, 0});
  // What the lens did not see is 31/32 for every polygon, and no texel.
  camera_.distortion_model = DistortionModel::plumb_bob;
  camera_.distortion = {0.6, 0, 0, 0, 0, 0, 0, 0};
  add_quad(mesh, -3, -3, 3, 3, 1.5);
  build(mesh);
  const auto wall = pipeline_->inspect(frame(), polygon_at({0, 0, 1.5}));
  EXPECT_EQ(wall.box_alpha_before.at<float>(0, 0), kOutside);

  camera_.distortion_model = DistortionModel::none;
  const CameraFrame picture = frame();
  cv::Mat bgr[4];
  cv::split(pipeline_->undistorted(picture), bgr);
  EXPECT_EQ(cv::countNonZero(bgr[3] != 255), 0);
  cv::Mat plain_picture;
  cv::merge(bgr, 3, plain_picture);
  EXPECT_EQ(cv::norm(plain_picture, picture.picture, cv::NORM_INF), 0);
}

TEST_F(ExtractionTest, TimesStepsWhenAsked) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  pipeline_->set_timing(ExtractionTiming::finish);
  const ExtractionStatistics s = pipeline_->extract(frame());
  EXPECT_GT(s.ms(ExtractionStep::upload), 0);
  EXPECT_GT(s.ms(ExtractionStep::normalisation), 0);
  EXPECT_GT(s.ms(ExtractionStep::filling), 0);
  double sum = 0;
  for (const double ms : s.step_ms) sum += ms;
  EXPECT_NEAR(s.total_ms, sum, 0.01);
}

TEST_F(ExtractionTest, CountsTexelsAndDraws) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  const cv::Mat fused = pipeline_->inspect(frame(), polygon_at({0, 0, 1})).fused;
  const ExtractionStatistics s = pipeline_->extract(frame());
  EXPECT_EQ(s.charts_touched, 1U);
  EXPECT_EQ(s.texels_written, fused.total());
  EXPECT_EQ(s.texels_filled, fused.total());
  // Depth, mask, three diamond passes, normalisation, the pyramid's tip, chart, levels, colours of never-seen polygons.
  EXPECT_GE(s.draw_calls, 10U);
  EXPECT_EQ(s.passes, s.draw_calls);
  // Two more passes of suppression are two more passes.
  options_.passes += 2;
  build(mesh);
  EXPECT_EQ(pipeline_->extract(frame()).passes, s.passes + 2);
}

void expect_input_error(const std::function<void()>& action, const std::string& part_of_text) {
  try {
    action();
    ADD_FAILURE() << "no error, expected one with '" << part_of_text << "'";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(part_of_text), std::string::npos) << error.what();
  }
}

TEST_F(ExtractionTest, RefusesWhatCannotBe) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  ChartOptions too_large = charts_;
  too_large.max_texels = limit + 1;
  expect_input_error([&] { PerPolygonExtraction(*store_, too_large, options_); }, "--max-texels");
  expect_input_error([&] { PerPolygonExtraction(*store_, too_large, options_); }, std::to_string(limit));

  RawMesh pair = mesh;
  const auto more = static_cast<std::uint32_t>(pair.vertices.size());
  pair.vertices.emplace_back(-0.64, 0, 1);
  pair.faces.push_back({pair.faces[0][1], pair.faces[0][0], more});
  ImportOptions import;
  import.backdrop = false;
  import.merge_coplanar = false;
  const PolygonModel neighbours = build_polygon_model(pair, import);
  ChartOptions grouped = charts_;
  grouped.group_polygons = true;
  const ChartLayout layout = lay_out_charts(neighbours, grouped);
  ASSERT_EQ(neighbours.polygons().size(), 2U);
  if (layout.groups.size() == 1) {
    TextureStore store(neighbours, layout);
    expect_input_error([&] { PerPolygonExtraction(store, grouped, options_); }, "group_polygons");
  } else {
    ADD_FAILURE() << "the polygons are not grouped";
  }

  CameraFrame wrong_size = frame();
  wrong_size.picture = wrong_size.picture(cv::Rect(0, 0, 100, 100)).clone();
  expect_input_error([&] { pipeline_->extract(wrong_size); }, "100x100 pixels, expected its camera's 160x120");
  CameraFrame grey = frame();
  grey.picture = cv::Mat(120, 160, CV_8U);
  expect_input_error([&] { pipeline_->extract(grey); }, "no picture");
  CameraFrame no_parts = frame();
  no_parts.state.world_from_part.clear();
  expect_input_error([&] { pipeline_->extract(no_parts); }, "0 parts, expected the model's 1");
  CameraFrame lost = frame();
  lost.state.world_from_camera.translation.x = std::nan("");
  expect_input_error([&] { pipeline_->extract(lost); }, "not finite");
  CameraFrame blind = frame();
  blind.camera.focal_length.y = 0;
  expect_input_error([&] { pipeline_->extract(blind); }, "focal length");
  expect_input_error([&] { (void)pipeline_->inspect(frame(), 1); }, "polygon 1");
  // Still usable.
  EXPECT_EQ(pipeline_->extract(frame()).polygons_visible, 1U);
}

TEST_F(ExtractionTest, TakesPicturesWithPaddedRows) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  build(mesh);
  CameraFrame padded = frame();
  for (const int padding : {1, 2, 3}) {
    cv::Mat wider(120, 160 + padding, CV_8UC3, cv::Scalar::all(1));
    padded.picture.copyTo(wider(cv::Rect(padding, 0, 160, 120)));
    CameraFrame part = padded;
    part.picture = wider(cv::Rect(padding, 0, 160, 120));
    EXPECT_EQ(cv::norm(pipeline_->undistorted(part), pipeline_->undistorted(padded), cv::NORM_INF), 0);
  }
}

TEST(ExtractionOptions, NamesTheOptionThatIsOutOfRange) {
  EXPECT_NO_THROW(ExtractionOptions().validate());
  const auto with = [](auto change) {
    ExtractionOptions options;
    change(options);
    return [options] { options.validate(); };
  };
  expect_input_error(with([](ExtractionOptions& o) { o.passes = -1; }), "--passes");
  expect_input_error(with([](ExtractionOptions& o) { o.passes = 1000000; }), "--passes");
  expect_input_error(with([](ExtractionOptions& o) { o.alpha_c = 2.9; }), "--alpha-c");
  expect_input_error(with([](ExtractionOptions& o) { o.alpha_c = 3.875; }), "--alpha-c");
  expect_input_error(with([](ExtractionOptions& o) { o.alpha_c = std::nan(""); }), "--alpha-c");
  expect_input_error(with([](ExtractionOptions& o) { o.small_texture = -1; }), "--small-texture");
  expect_input_error(with([](ExtractionOptions& o) { o.near_plane = 0; }), "--near-plane");
}

}  // namespace
}  // namespace foreview
