// What must hold of the batched pipeline whatever its rules say; these themselves are compared with the oracle.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "foreview/gpu/batched/page_targets.h"
#include "gpu/batched_scene.h"

namespace foreview {
namespace {

/// Pipelines made meanwhile draw layer by layer.
struct LayersForbidden {
  LayersForbidden() { batched::forbid_drawing_layers(true); }
  ~LayersForbidden() { batched::forbid_drawing_layers(false); }
  LayersForbidden(const LayersForbidden&) = delete;
  LayersForbidden& operator=(const LayersForbidden&) = delete;
};

TEST_F(BatchedTest, SceneIsWorthTheTests) {
  const PolygonModel model = cluttered_room();
  BatchedRig rig(model, charts_);
  ASSERT_GT(rig.store.layout().pages, 2U);
  int late = 0, distorted = 0;
  std::set<int> widths;
  Timestamp newest;
  for (const CameraFrame& picture : pictures(model, 24, 1)) {
    rig.pipeline.extract(picture);
    late += picture.state.stamp < newest ? 1 : 0;
    newest = std::max(newest, picture.state.stamp);
    distorted += picture.camera.is_distorted() ? 1 : 0;
    widths.insert(picture.camera.width);
  }
  EXPECT_GT(late, 2);
  EXPECT_GT(distorted, 2);
  EXPECT_EQ(widths.size(), 3U);
  const TextureBytes bytes = rig.bytes();
  EXPECT_GT(bytes.count_observed(), 20000);
  const auto seen =
      std::count_if(bytes.states.begin(), bytes.states.end(), [](const auto& state) { return state.seen == 1; });
  EXPECT_GT(seen, static_cast<int>(model.polygons().size()) * 3 / 4);
}

TEST_F(BatchedTest, DrawingLayerByLayerGivesTheSame) {
  if (!batched::can_draw_layers()) GTEST_SKIP() << "this driver always draws layer by layer";
  const PolygonModel model = cluttered_room();
  BatchedRig together(model, charts_);
  std::unique_ptr<BatchedRig> one_by_one;
  {
    const LayersForbidden forbidden;
    one_by_one = std::make_unique<BatchedRig>(model, charts_);
  }
  // The set's targets are made with the first picture.
  for (const CameraFrame& picture : pictures(model, 8, 2)) {
    together.pipeline.extract(picture);
    const LayersForbidden forbidden;
    one_by_one->pipeline.extract(picture);
    ASSERT_EQ(difference(one_by_one->bytes(), together.bytes()), "") << picture.state.stamp.to_string();
    for (int level = 1; level < kChartLevels; ++level) {
      const std::vector<cv::Mat> a = one_by_one->pipeline.pulled(level), b = together.pipeline.pulled(level);
      for (std::size_t page = 0; page < a.size(); ++page) ASSERT_EQ(cv::norm(a[page], b[page], cv::NORM_INF), 0);
    }
  }
}

TEST_F(BatchedTest, ThreeSetsHoldTheSameAsOne) {
  const PolygonModel model = cluttered_room();
  BatchedRig direct(model, charts_), buffered(model, charts_, {}, Publishing::buffered);
  std::set<GLuint> sets;
  bool holding = false;
  int step = 0;
  for (const CameraFrame& picture : pictures(model, 30, 3)) {
    ++step;
    direct.pipeline.extract(picture);
    buffered.pipeline.extract(picture);
    sets.insert(buffered.store.pages());
    ASSERT_EQ(difference(buffered.bytes(), direct.bytes()), "") << "picture " << step;
    glFinish();
    // The display often keeps a set over some pictures.
    if (holding && step % 3 != 0) continue;
    if (holding) buffered.store.release();
    const TextureStore::Shown shown = buffered.store.acquire();
    holding = true;
    EXPECT_EQ(shown.picture, static_cast<std::uint64_t>(step));
    ASSERT_EQ(difference(TextureBytes::of(buffered.store, shown.pages, shown.polygon_states, shown.capture_times),
                         direct.bytes()),
              "")
        << "shown with picture " << step;
  }
  if (holding) buffered.store.release();
  EXPECT_EQ(sets.size(), 3U);
}

TEST_F(BatchedTest, SamePicturesGiveTheSameBytes) {
  const PolygonModel model = cluttered_room();
  BatchedRig first(model, charts_), second(model, charts_);
  for (const CameraFrame& picture : pictures(model, 16, 4)) {
    first.pipeline.extract(picture);
    second.pipeline.extract(picture);
  }
  EXPECT_EQ(difference(first.bytes(), second.bytes()), "");
}

TEST_F(BatchedTest, SamePictureAgainChangesNothing) {
  const PolygonModel model = cluttered_room();
  BatchedRig rig(model, charts_);
  for (const CameraFrame& picture : pictures(model, 6, 5)) {
    rig.pipeline.extract(picture);
    const TextureBytes before = rig.bytes();
    rig.pipeline.extract(picture);
    const TextureBytes after = rig.bytes();
    ASSERT_EQ(before.count_observed(), after.count_observed());
    // What was observed; of what was filled, holes whose fill hardly changed may follow now.
    for (std::size_t page = 0; page < before.levels[0].size(); ++page) {
      const cv::Mat_<cv::Vec4b>&a = before.levels[0][page], &b = after.levels[0][page];
      for (int y = 0; y < a.rows; ++y) {
        for (int x = 0; x < a.cols; ++x) {
          if (a(y, x)[3] == 255) {
            ASSERT_EQ(a(y, x), b(y, x)) << x << ", " << y << " of page " << page;
          }
        }
      }
    }
  }
}

/// A picture that shows nothing and is as large as any of BatchedTest::pictures(). Pictures lie in textures as large as
/// the largest so far, and places in them are divided by that size before they are sampled: in a new and a used one,
/// bilinear samples may else differ by rounding.
void show_nothing(BatchedRig& rig) {
  CameraModel camera;
  camera.width = 233;
  camera.height = 170;
  camera.focal_length = {100, 100};
  CameraFrame frame;
  frame.camera = camera;
  frame.picture = cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar::all(0));
  frame.state.world_from_camera.translation = {0, 0, 10};
  frame.state.world_from_part.resize(rig.store.model().parts().size());
  rig.pipeline.extract(frame);
}

TEST_F(BatchedTest, ClearedPipelineIsAsNew) {
  const PolygonModel model = cluttered_room();
  BatchedRig used(model, charts_), fresh(model, charts_);
  for (const CameraFrame& picture : pictures(model, 10, 6)) used.pipeline.extract(picture);
  used.pipeline.clear();
  EXPECT_EQ(difference(used.bytes(), fresh.bytes()), "");
  show_nothing(used);
  show_nothing(fresh);
  // Older stamps too: those before are forgotten.
  int step = 0;
  for (const CameraFrame& picture : pictures(model, 8, 7)) {
    used.pipeline.extract(picture);
    fresh.pipeline.extract(picture);
    ASSERT_EQ(difference(used.bytes(), fresh.bytes()), "") << "picture " << ++step;
  }
}

/// A wall, and a plate before its middle that can go away.
class LatePictures : public BatchedTest {
 protected:
  LatePictures() {
    RawMesh mesh;
    mesh.part_names = {"wall", "plate"};
    add_quad(mesh, -0.5, -0.4, 0.5, 0.4, 1);
    add_quad(mesh, -0.1, -0.1, 0.1, 0.1, 0.5);
    mesh.face_part = {0, 1};
    model_ = import_as_it_is(mesh);
  }
  [[nodiscard]] CameraFrame picture(double grey, double seconds, bool plate_away) const {
    CameraFrame result = frame(model_, plain(grey), seconds);
    if (plate_away) result.state.world_from_part[1].translation = {9, 0, 0};
    return result;
  }
  /// Observed greys of the wall's chart and how often each.
  [[nodiscard]] std::map<int, int> observed(const BatchedRig& rig) const {
    const std::size_t wall = model_.polygons()[0].part == 0 ? 0 : 1;
    const Chart& chart = rig.store.layout().charts[wall];
    const cv::Mat_<cv::Vec4b> page = rig.store.read_pages()[chart.page];
    std::map<int, int> found;
    for (int y = 0; y < chart.size.y; ++y) {
      for (int x = 0; x < chart.size.x; ++x) {
        const cv::Vec4b& texel = page(chart.origin.y + y, chart.origin.x + x);
        if (texel[3] == 255) ++found[texel[0]];
      }
    }
    return found;
  }
  PolygonModel model_;
};

TEST_F(LatePictures, OnlyFillWhatIsNotObserved) {
  BatchedRig rig(model_, charts_);
  rig.pipeline.extract(picture(100, 1, false));
  const std::map<int, int> first = observed(rig);
  ASSERT_EQ(first.size(), 1U);
  rig.pipeline.extract(picture(150, 3, false));
  EXPECT_EQ(observed(rig), (std::map<int, int>{{150, first.at(100)}})) << "newer overwrites";
  rig.pipeline.extract(picture(50, 2, true));
  const std::map<int, int> filled = observed(rig);
  ASSERT_EQ(filled.size(), 2U);
  EXPECT_EQ(filled.at(150), first.at(100)) << "late keeps off what is observed";
  EXPECT_GT(filled.at(50), 40 * 40 - 1) << "late fills where the plate was";
  // Later than the one that filled, but late still.
  rig.pipeline.extract(picture(70, 2.5, true));
  EXPECT_EQ(observed(rig), filled);
  rig.pipeline.extract(picture(220, 4, true));
  EXPECT_EQ(observed(rig), (std::map<int, int>{{220, filled.at(50) + filled.at(150)}}));
  // A picture of the same stamp is not late.
  rig.pipeline.extract(picture(225, 4, true));
  EXPECT_EQ(observed(rig).begin()->first, 225);
}

TEST_F(LatePictures, CloseOnesToo) {
  // So near that texels are larger than two pixels: several samples a texel, which a pass of its own takes.
  charts_.texels_per_metre = 40;
  BatchedRig rig(model_, charts_);
  const std::map<int, int> before = [&] {
    rig.pipeline.extract(picture(150, 3, false));
    return observed(rig);
  }();
  ASSERT_EQ(before.size(), 1U);
  rig.pipeline.extract(picture(50, 2, true));
  const std::map<int, int> after = observed(rig);
  ASSERT_EQ(after.size(), 2U);
  EXPECT_EQ(after.at(150), before.at(150));
}

/// By page, 8-bit: 255 where a level's texel lies in a polygon, or less than half a texel beside it.
std::vector<cv::Mat> shown_texels(const TextureStore& store, int level) {
  const ChartLayout& layout = store.layout();
  std::vector<cv::Mat> masks;
  const int size = layout.page_size >> level;
  for (std::uint32_t page = 0; page < layout.pages; ++page) masks.emplace_back(size, size, CV_8UC1, cv::Scalar(0));
  for (std::size_t i = 0; i < layout.charts.size(); ++i) {
    const Chart& chart = layout.charts[i];
    std::vector<cv::Point2f> corners;
    for (std::size_t k = 0; k < store.model().polygons()[i].corner_count; ++k) {
      const glm::dvec2 texel = chart.texel_from_part(store.model().corner(i, k)) / static_cast<double>(1 << level);
      corners.emplace_back(static_cast<float>(texel.x), static_cast<float>(texel.y));
    }
    for (int y = chart.origin.y >> level; y < (chart.origin.y + chart.size.y) >> level; ++y) {
      for (int x = chart.origin.x >> level; x < (chart.origin.x + chart.size.x) >> level; ++x) {
        const cv::Point2f centre(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
        if (cv::pointPolygonTest(corners, centre, true) > -0.5) masks[chart.page].at<uchar>(y, x) = 255;
      }
    }
  }
  return masks;
}

struct Deviation {
  double greatest = 0, mean = 0;
  double off = 0;  ///< share that differs by more than 3
};
/// Over all colours of a level where `masks` are set, in 1/255.
Deviation deviation(const TextureBytes& a, const TextureBytes& b, int level, const std::vector<cv::Mat>& masks) {
  Deviation result;
  double sum = 0;
  std::size_t count = 0;
  const auto &pages = a.levels[static_cast<std::size_t>(level)], &others = b.levels[static_cast<std::size_t>(level)];
  for (std::size_t page = 0; page < pages.size(); ++page) {
    const cv::Mat_<cv::Vec4b>&x = pages[page], &y = others[page];
    for (int row = 0; row < x.rows; ++row) {
      for (int column = 0; column < x.cols; ++column) {
        if (masks[page].at<uchar>(row, column) == 0) continue;
        for (int c = 0; c < 3; ++c) {
          const double d = std::abs(static_cast<double>(x(row, column)[c]) - y(row, column)[c]);
          result.greatest = std::max(result.greatest, d);
          sum += d;
          result.off += d > 3 ? 1 : 0;
          ++count;
        }
      }
    }
  }
  result.mean = sum / static_cast<double>(count);
  result.off /= static_cast<double>(count);
  return result;
}

void hand_over(const BatchedRig& from, BatchedRig& to) {
  to.store.write_pages(from.store.read_pages(), from.store.read_polygon_states());
  to.pipeline.adopt_store();
}

TEST_F(BatchedTest, AdoptedTexturesGoOnAsIfNothingHadHappened) {
  const PolygonModel model = cluttered_room();
  BatchedRig original(model, charts_), adopted(model, charts_);
  show_nothing(original);
  show_nothing(adopted);
  const std::vector<CameraFrame> all = pictures(model, 12, 8);
  for (std::size_t i = 0; i < 6; ++i) original.pipeline.extract(all[i]);
  hand_over(original, adopted);
  const TextureBytes loaded = adopted.bytes();
  EXPECT_EQ(
      difference({{loaded.levels[0]}, loaded.states, {}}, {{original.bytes().levels[0]}, original.bytes().states, {}}),
      "");
  for (int level = 1; level < kChartLevels; ++level) {
    const std::vector<cv::Mat> a = adopted.pipeline.pulled(level), b = original.pipeline.pulled(level);
    for (std::size_t page = 0; page < a.size(); ++page) EXPECT_EQ(cv::norm(a[page], b[page], cv::NORM_INF), 0);
  }
  Timestamp newest = all[0].state.stamp;
  for (std::size_t i = 1; i < 6; ++i) newest = std::max(newest, all[i].state.stamp);
  int compared = 0;
  for (std::size_t i = 6; i < all.size(); ++i) {
    // Stamps are not saved: what is late for the original is not for the other.
    if (all[i].state.stamp < newest) continue;
    newest = std::max(newest, all[i].state.stamp);
    ++compared;
    original.pipeline.extract(all[i]);
    adopted.pipeline.extract(all[i]);
    const TextureBytes a = adopted.bytes(), b = original.bytes();
    for (std::size_t page = 0; page < a.levels[0].size(); ++page) {
      const cv::Mat_<cv::Vec4b>&x = a.levels[0][page], &y = b.levels[0][page];
      for (int row = 0; row < x.rows; ++row) {
        for (int column = 0; column < x.cols; ++column) {
          ASSERT_EQ(x(row, column)[3], y(row, column)[3]);
          if (x(row, column)[3] == 255) {
            ASSERT_EQ(x(row, column), y(row, column));
          }
        }
      }
    }
    // Fills may differ: those that would hardly change are left alone, and so are the last holes of a patch that is
    // nearly full; what is left alone depends on what the pipeline itself has done so far.
    std::cout << "picture " << i << ", largest and mean difference in 1/255:";
    for (int level = 0; level < kChartLevels; ++level) {
      const Deviation d = deviation(a, b, level, shown_texels(adopted.store, level));
      std::cout << "  level " << level << ": " << d.greatest << ", " << d.mean;
      if (level > 0) {
        EXPECT_LE(d.greatest, 2) << "level " << level;
      }
      EXPECT_LE(d.mean, 0.2) << "level " << level;
      EXPECT_LE(d.off, 0.0001) << "level " << level;
    }
    std::cout << "\n";
    for (std::size_t k = 0; k < a.states.size(); ++k) {
      EXPECT_EQ(a.states[k].seen, b.states[k].seen);
      EXPECT_NEAR(a.states[k].red, b.states[k].red, 1e-6) << k;
    }
  }
  EXPECT_GE(compared, 4);
}

TEST_F(BatchedTest, AdoptingForgetsWhatThePipelineItselfHasSeen) {
  const PolygonModel model = cluttered_room();
  BatchedRig source(model, charts_), used(model, charts_), fresh(model, charts_);
  show_nothing(used);
  show_nothing(fresh);
  const std::vector<CameraFrame> all = pictures(model, 8, 9);
  source.pipeline.extract(all[0]);
  for (std::size_t i = 1; i < 6; ++i) used.pipeline.extract(all[i]);
  hand_over(source, used);
  hand_over(source, fresh);
  EXPECT_EQ(difference(used.bytes(), fresh.bytes()), "");
  for (std::size_t i = 6; i < 8; ++i) {
    used.pipeline.extract(all[i]);
    fresh.pipeline.extract(all[i]);
    ASSERT_EQ(difference(used.bytes(), fresh.bytes()), "") << i;
  }
}

TEST_F(BatchedTest, AdoptingChangesNothingUnderTheDisplaysEyes) {
  const PolygonModel model = cluttered_room();
  BatchedRig source(model, charts_), rig(model, charts_, {}, Publishing::buffered);
  const std::vector<CameraFrame> all = pictures(model, 9, 10);
  for (std::size_t i = 0; i < 4; ++i) source.pipeline.extract(all[i]);
  rig.store.write_pages(source.store.read_pages(), source.store.read_polygon_states());
  glFinish();
  const TextureStore::Shown shown = rig.store.acquire();
  const TextureBytes before = TextureBytes::of(rig.store, shown.pages, shown.polygon_states, shown.capture_times);
  rig.pipeline.adopt_store();
  EXPECT_EQ(difference(TextureBytes::of(rig.store, shown.pages, shown.polygon_states, shown.capture_times), before),
            "");
  rig.store.release();
  // All three sets go on from there.
  BatchedRig direct(model, charts_);
  hand_over(source, direct);
  for (std::size_t i = 4; i < all.size(); ++i) {
    rig.pipeline.extract(all[i]);
    direct.pipeline.extract(all[i]);
    ASSERT_EQ(difference(rig.bytes(), direct.bytes()), "") << i;
    glFinish();
    static_cast<void>(rig.store.acquire());
    rig.store.release();
  }
}

/// Pictures that show nothing leave everything as it is.
TEST_F(BatchedTest, NothingIsTakenFromPicturesThatShowNothing) {
  const PolygonModel model = cluttered_room();
  BatchedRig rig(model, charts_);
  const auto expect_untouched = [&](CameraFrame picture, const std::string& what) {
    const TextureBytes before = rig.bytes();
    picture.state.stamp = Timestamp::from_seconds(1000);
    rig.pipeline.set_counting(true);
    const ExtractionStatistics statistics = rig.pipeline.extract(picture);
    rig.pipeline.set_counting(false);
    EXPECT_EQ(statistics.texels_observed, 0U) << what;
    EXPECT_EQ(difference(rig.bytes(), before), "") << what;
    return statistics;
  };
  const std::vector<CameraFrame> some = pictures(model, 5, 11);
  for (int round = 0; round < 2; ++round) {
    const std::string when = round == 0 ? ", first of all" : ", after others";
    CameraFrame behind = frame(model, gradient);
    behind.state.world_from_camera.translation = {0, 0, 10};
    const ExtractionStatistics statistics = expect_untouched(behind, "before everything" + when);
    EXPECT_EQ(statistics.polygons_skipped_outside, model.polygons().size());
    EXPECT_EQ(statistics.texels_written, 0U);

    CameraModel tiny = camera_;
    tiny.width = tiny.height = 1;
    tiny.principal_point = {0.5, 0.5};
    const ExtractionStatistics of_tiny = expect_untouched(frame(model, tiny, gradient, 1), "1 x 1 pixel" + when);
    EXPECT_GT(of_tiny.polygons_visible, 0U);
    EXPECT_EQ(of_tiny.texels_written, 0U);
    tiny.height = 40;
    tiny.principal_point = {0.5, 20};
    expect_untouched(frame(model, tiny, gradient, 1), "1 x 40 pixels" + when);

    // The plates' backs, from so near that nothing else is in the picture.
    CameraFrame backs = frame(model, gradient);
    backs.state.world_from_camera = looking_at({0.25, 0.05, 0.95}, {0.25, 0.05, 0}, {0, -1, 0});
    EXPECT_GE(expect_untouched(backs, "back of a plate" + when).polygons_skipped_back_face, 1U);
    for (const CameraFrame& picture : some) rig.pipeline.extract(picture);
  }
}

TEST_F(BatchedTest, FourPixelsAreEnough) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  const PolygonModel model = import_as_it_is(mesh);
  BatchedRig rig(model, charts_);
  rig.pipeline.set_counting(true);
  CameraModel four = camera_;
  four.width = four.height = 2;
  // The cell between the four pixels spans one texel of 1 cm.
  four.principal_point = {1.0, 1.0};
  four.focal_length = {40, 40};
  const ExtractionStatistics statistics = rig.pipeline.extract(frame(model, four, plain(90), 1));
  // From -1/80 m to 1/80 m lie 2.5 texels.
  EXPECT_GE(statistics.texels_observed, 4U);
  EXPECT_LE(statistics.texels_observed, 9U);
  const TextureBytes bytes = rig.bytes();
  EXPECT_EQ(static_cast<std::size_t>(bytes.count_observed()), statistics.texels_observed);
  EXPECT_EQ(bytes.states[0].seen, 1);
  EXPECT_NEAR(bytes.states[0].green * 255, 90, 1e-3);
  for (int level = 0; level < kChartLevels; ++level) {
    const Chart& chart = rig.store.layout().charts[0];
    const cv::Vec4b& texel = bytes.levels[static_cast<std::size_t>(level)][0].at<cv::Vec4b>(
        (chart.origin.y + 10) >> level, (chart.origin.x + 10) >> level);
    EXPECT_NEAR(texel[1], 90, 1) << "filled at level " << level;
  }
}

TEST_F(BatchedTest, CameraInAPolygonsPlane) {
  RawMesh mesh;
  mesh.vertices = {{-0.5, 0.1, 0.5}, {-0.5, 0.1, 1.5}, {0.5, 0.1, 1.5}, {0.5, 0.1, 0.5}};  // y = 0.1, front upwards
  mesh.faces = {{0, 3, 2, 1}};
  const PolygonModel model = import_as_it_is(mesh);
  BatchedRig rig(model, charts_);
  rig.pipeline.set_counting(true);
  for (const double height : {0.1, 0.1 + 1e-12, 0.1 - 1e-12, 0.1 - 1e-7}) {
    CameraFrame edge_on = frame(model, plain(200));
    edge_on.state.world_from_camera.translation.y = height;
    EXPECT_EQ(rig.pipeline.extract(edge_on).texels_observed, 0U) << height;
  }
  CameraFrame above = frame(model, plain(200));
  above.state.world_from_camera.translation.y = -0.1;
  CameraFrame below = above;
  below.state.world_from_camera.translation.y = 0.3;
  const bool front_is_above = model.polygons()[0].normal.y < 0;
  EXPECT_EQ(rig.pipeline.extract(front_is_above ? below : above).texels_observed, 0U);
  EXPECT_GT(rig.pipeline.extract(front_is_above ? above : below).texels_observed, 1000U);
}

TEST_F(BatchedTest, PartsTakeTheirTexturesAlong) {
  RawMesh mesh;
  mesh.part_names = {"wall", "plate"};
  add_quad(mesh, -1.5, -1, 1.5, 1, 2);
  add_quad(mesh, -0.3, -0.2, 0.3, 0.2, 1);
  mesh.face_part = {0, 1};
  const PolygonModel model = import_as_it_is(mesh);
  BatchedRig rig(model, charts_);
  const auto paint = [](const glm::dvec3& p) {
    return cv::Vec3d(127 + 300 * p.x, 127 + 400 * p.y, 127 - 150 * p.x + 150 * p.y);
  };
  // From here and there, a half of the plate in each picture.
  int step = 0;
  for (const glm::dvec3 shift : {glm::dvec3(-0.7, 0.1, 0), glm::dvec3(0.65, -0.1, 0.2), glm::dvec3(0.1, -0.55, -0.2)}) {
    CameraFrame picture = frame(
        model,
        [&](double u, double v) {
          const double z = 1 + shift.z;
          const glm::dvec3 p((u - camera_.principal_point.x) / 100 * z, (v - camera_.principal_point.y) / 100 * z, z);
          const glm::dvec3 in_part = p - shift;
          const bool on_plate = std::abs(in_part.x) < 0.32 && std::abs(in_part.y) < 0.22;
          return on_plate ? paint(in_part) : cv::Vec3d(0, 0, 0);
        },
        ++step);
    picture.state.world_from_part[1].translation = shift;
    rig.pipeline.extract(picture);
  }
  const std::uint32_t plate = model.polygons()[0].part == 1 ? 0 : 1;
  const Chart& chart = rig.store.layout().charts[plate];
  const cv::Mat_<cv::Vec4b> page = rig.store.read_pages()[chart.page];
  int observed = 0;
  for (int y = 0; y < chart.inner.y; ++y) {
    for (int x = 0; x < chart.inner.x; ++x) {
      const glm::ivec2 texel = chart.origin + kChartGutter + glm::ivec2(x, y);
      const cv::Vec4b& got = page(texel.y, texel.x);
      if (got[3] != 255) continue;
      ++observed;
      const cv::Vec3d expected = paint(chart.part_from_texel(glm::dvec2(texel) + 0.5));
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], expected[c], 3) << x << ", " << y;
    }
  }
  EXPECT_GT(observed, 60 * 40 * 9 / 10);
}

TEST_F(BatchedTest, WhatTheContextWasSetToDoesNotMatterAndIsLeftInOrder) {
  const PolygonModel model = cluttered_room();
  BatchedRig expected(model, charts_), rig(model, charts_);
  const GlSampler sampler = GlSampler::create();
  glSamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  glSamplerParameteri(sampler.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  const std::vector<CameraFrame> all = pictures(model, 6, 12);
  // One that is late and one with a lens: every branch.
  for (const CameraFrame& picture : all) {
    expected.pipeline.extract(picture);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, 3, 3);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ZERO, GL_ONE);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT_AND_BACK);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    for (GLuint unit = 0; unit < 3; ++unit) glBindSampler(unit, sampler.id());
    rig.pipeline.extract(picture);
    for (const GLenum off : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_STENCIL_TEST,
                             GL_RASTERIZER_DISCARD, GL_DITHER, GL_POLYGON_OFFSET_FILL}) {
      EXPECT_EQ(glIsEnabled(off), GL_FALSE) << std::hex << off;
    }
    for (GLenum i = 0; i < 8; ++i) EXPECT_EQ(glIsEnabled(GL_CLIP_DISTANCE0 + i), GL_FALSE) << i;
    const auto integer = [](GLenum name) {
      GLint value = -1;
      glGetIntegerv(name, &value);
      return value;
    };
    EXPECT_EQ(integer(GL_DEPTH_FUNC), GL_GREATER);
    EXPECT_EQ(integer(GL_DEPTH_WRITEMASK), GL_TRUE);
    EXPECT_EQ(integer(GL_CLIP_ORIGIN), GL_LOWER_LEFT);
    EXPECT_EQ(integer(GL_CLIP_DEPTH_MODE), GL_ZERO_TO_ONE);
    EXPECT_EQ(integer(GL_FRONT_FACE), GL_CW);
    EXPECT_EQ(integer(GL_PACK_ALIGNMENT), 1);
    EXPECT_EQ(integer(GL_UNPACK_ALIGNMENT), 1);
    EXPECT_EQ(integer(GL_DRAW_INDIRECT_BUFFER_BINDING), 0);
    EXPECT_EQ(integer(GL_DISPATCH_INDIRECT_BUFFER_BINDING), 0);
    EXPECT_EQ(integer(GL_PIXEL_UNPACK_BUFFER_BINDING), 0);
    EXPECT_EQ(integer(GL_PIXEL_PACK_BUFFER_BINDING), 0);
    GLboolean mask[4] = {};
    glGetBooleanv(GL_COLOR_WRITEMASK, mask);
    EXPECT_TRUE(mask[0] && mask[1] && mask[2] && mask[3]);
    for (GLuint unit = 0; unit < 3; ++unit) {
      GLint bound = -1;
      glGetIntegeri_v(GL_SAMPLER_BINDING, unit, &bound);
      EXPECT_EQ(bound, 0) << unit;
    }
  }
  EXPECT_EQ(difference(rig.bytes(), expected.bytes()), "");
  glCullFace(GL_BACK);
}

TEST_F(BatchedTest, NothingIsCreatedWhileRunning) {
  const PolygonModel model = cluttered_room();
  const std::vector<CameraFrame> all = pictures(model, 24, 13);
  for (const Publishing publishing : {Publishing::direct, Publishing::buffered}) {
    BatchedRig rig(model, charts_, {}, publishing);
    // Targets are made with the first picture in each set, and grow with the pictures.
    for (const CameraFrame& picture : all) rig.pipeline.extract(picture);
    glFinish();
    const long before = live_gl_objects();
    for (const CameraFrame& picture : all) {
      rig.pipeline.extract(picture);
      // At most a fence behind each set.
      EXPECT_LE(live_gl_objects(), before + (publishing == Publishing::direct ? 0 : 3));
    }
  }
}

TEST_F(BatchedTest, CountersAddUp) {
  const PolygonModel model = cluttered_room();
  for (const bool grouped : {true, false}) {
    charts_.group_polygons = grouped;
    BatchedRig rig(model, charts_);
    rig.pipeline.set_counting(true);
    int before = 0;
    std::size_t all_taken = 0;
    Timestamp newest;
    for (const CameraFrame& picture : pictures(model, 12, 14)) {
      const ExtractionStatistics s = rig.pipeline.extract(picture);
      EXPECT_EQ(
          s.polygons_visible + s.polygons_skipped_back_face + s.polygons_skipped_outside + s.polygons_skipped_too_small,
          model.polygons().size());
      EXPECT_LE(s.charts_touched, rig.store.layout().groups.size());
      EXPECT_LE(s.charts_touched, s.polygons_visible);
      EXPECT_LE(s.texels_observed, s.texels_written);
      EXPECT_LE(s.passes, s.draw_calls);
      EXPECT_LE(s.texels_filled, rig.store.layout().allocated_texels * 4) << "whole patches of 32 x 32 texels";
      const int after = rig.bytes().count_observed();
      EXPECT_GE(static_cast<int>(s.texels_observed), after - before) << "took at least what is new";
      before = after;
      all_taken += s.texels_observed;
      newest = std::max(newest, picture.state.stamp);
    }
    EXPECT_GT(all_taken, static_cast<std::size_t>(before)) << "some were seen more than once";
  }
}

TEST_F(BatchedTest, ObservedTexelsAreCountedExactly) {
  RawMesh mesh;
  add_quad(mesh, -0.32, -0.32, 0.32, 0.32, 1);
  const PolygonModel model = import_as_it_is(mesh);
  BatchedRig rig(model, charts_);
  const CameraFrame picture = frame(model, gradient);
  EXPECT_EQ(rig.pipeline.extract(picture).texels_observed, 0U) << "not asked for";
  rig.pipeline.set_counting(true);
  for (int i = 0; i < 2; ++i) {
    const ExtractionStatistics s = rig.pipeline.extract(picture);
    // A single convex polygon: its gutter overlaps with nothing.
    EXPECT_EQ(s.texels_observed, static_cast<std::size_t>(rig.bytes().count_observed())) << "picture " << i;
    EXPECT_GE(s.texels_observed, 62U * 62U);
    // 64 x 64 and 2 on each side, less the corners' rounding.
    EXPECT_NEAR(static_cast<double>(s.texels_written), 68 * 68 - 4, 4);
  }
}

TEST_F(BatchedTest, SmallPolygonsCountToo) {
  // Squares of a tenth of a texel: their shares must add up.
  RawMesh mesh;
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 20; ++column) {
      const double x = -0.1 + 0.01 * column, y = -0.1 + 0.01 * row;
      add_quad(mesh, x, y, x + 0.01, y + 0.01, 1);
    }
  }
  charts_.texels_per_metre = 30;
  charts_.group_polygons = false;
  const PolygonModel model = import_as_it_is(mesh);
  BatchedRig rig(model, charts_);
  const ExtractionStatistics s = rig.pipeline.extract(frame(model, gradient));
  EXPECT_EQ(s.polygons_visible, 400U);
  // Each with a gutter of two texels along its edges, and two wedges of 45 degrees at each corner.
  constexpr double kTexels = 0.3;
  EXPECT_NEAR(static_cast<double>(s.texels_written), 400 * (kTexels * kTexels + 8 * kTexels + 8 * std::sqrt(2.0)), 2);
}

TEST_F(BatchedTest, CommandsDoNotDependOnTheNumberOfPolygons) {
  const auto wall = [](int columns) {
    RawMesh mesh;
    // Higher than wide: the largest chart's longer side tells how many levels there are above the pages', two commands
    // each.
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < columns; ++column) {
        const double width = 1.2 / columns, x = -0.6 + width * column, y = -0.45 + 0.45 * row;
        add_quad(mesh, x, y, x + width, y + 0.45, 1);
      }
    }
    return import_as_it_is(mesh);
  };
  charts_.group_polygons = false;
  std::vector<ExtractionStatistics> first;  // colours are spread to what was never seen with the first picture
  for (const int columns : {4, 8, 16}) {
    const PolygonModel model = wall(columns);
    ASSERT_EQ(model.polygons().size(), static_cast<std::size_t>(2 * columns));
    BatchedRig rig(model, charts_);
    for (std::size_t i = 0; i < 2; ++i) {
      const ExtractionStatistics s = rig.pipeline.extract(frame(model, gradient));
      EXPECT_EQ(s.polygons_visible, model.polygons().size());
      if (columns == 4) {
        first.push_back(s);
        std::cout << "picture " << i << ": " << s.passes << " passes, " << s.draw_calls << " draw calls\n";
        EXPECT_GT(s.passes, 10U);
        EXPECT_LT(s.passes, 60U);
        continue;
      }
      EXPECT_EQ(s.passes, first[i].passes) << columns;
      EXPECT_EQ(s.draw_calls, first[i].draw_calls) << columns;
    }
  }
}

TEST_F(BatchedTest, ModelsOfOneTriangle) {
  RawMesh mesh;
  mesh.vertices = {{-0.3, -0.3, 1}, {-0.3, 0.3, 1}, {0.3, 0.3, 1}};
  mesh.faces = {{0, 1, 2}};
  const PolygonModel model = import_as_it_is(mesh);
  for (const double density : {30.0, 100.0, 1000.0}) {
    charts_.texels_per_metre = density;
    BatchedRig rig(model, charts_);
    rig.pipeline.extract(frame(model, plain(123)));
    const TextureBytes bytes = rig.bytes();
    EXPECT_EQ(bytes.states[0].seen, 1) << "at " << density << " texels per metre";
    EXPECT_NEAR(bytes.states[0].red * 255, 123, 0.1) << density;
  }
}

}  // namespace
}  // namespace foreview
