// TextureStore::capture_times(): when the picture was taken of which a block of texels has its colours.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "gpu/batched_scene.h"

namespace foreview {
namespace {

bool is_inside(const std::vector<glm::dvec2>& shape, const glm::dvec2& p) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const glm::dvec2 along = shape[(i + 1) % shape.size()] - shape[i], to = p - shape[i];
    (along.x * to.y - along.y * to.x > 0 ? left : right) += 1;
  }
  return left == 0 || right == 0;
}

/// By page, row and column of blocks: the texels that lie nearest to the block's middle, of those with their centre in
/// a polygon.
using Nearest = std::map<std::tuple<std::uint32_t, int, int>, std::vector<glm::ivec2>>;
Nearest nearest_to_the_middle(const PolygonModel& model, const ChartLayout& layout) {
  std::map<std::tuple<std::uint32_t, int, int>, double> best;
  Nearest result;
  for (std::uint32_t i = 0; i < model.polygons().size(); ++i) {
    const Chart& chart = layout.charts[i];
    std::vector<glm::dvec2> corners;
    for (const std::uint32_t vertex : model.corners_of(i)) {
      corners.push_back(chart.texel_from_part(model.vertices()[vertex]));
    }
    for (int y = chart.origin.y; y < chart.origin.y + chart.size.y; ++y) {
      for (int x = chart.origin.x; x < chart.origin.x + chart.size.x; ++x) {
        const glm::dvec2 centre = glm::dvec2(x, y) + 0.5;
        if (!is_inside(corners, centre)) continue;
        const std::tuple block(chart.page, y / 16, x / 16);
        const double distance = glm::distance(centre, glm::dvec2(glm::ivec2(x / 16, y / 16) * 16) + 8.0);
        const auto [known, is_new] = best.try_emplace(block, distance);
        if (!is_new && distance > known->second + 1e-9) continue;
        if (is_new || distance < known->second - 1e-9) result[block].clear();
        known->second = distance;
        result[block].emplace_back(x, y);
      }
    }
  }
  return result;
}

class CaptureTimesTest : public BatchedTest {};

TEST_F(CaptureTimesTest, AreThoseOfThePicturesThatGaveTheColours) {
  const PolygonModel model = cluttered_room();
  BatchedRig rig(model, charts_);
  const ChartLayout& layout = rig.store.layout();
  const Nearest nearest = nearest_to_the_middle(model, layout);
  // Every picture in a colour of its own, so that a texel tells whose it is.
  std::map<int, std::int32_t> time_of_grey;
  std::vector<CameraFrame> all = pictures(model, 12, 11);
  int judged = 0, wrong = 0, late_ones = 0;
  std::set<std::int32_t> times_seen;
  std::optional<Timestamp> newest;
  for (std::size_t k = 0; k < all.size(); ++k) {
    CameraFrame& picture = all[k];
    const int grey = 20 + 15 * static_cast<int>(k);
    picture.picture.setTo(cv::Scalar::all(grey));
    rig.pipeline.extract(picture);
    if (newest && picture.state.stamp < *newest) ++late_ones;
    newest = std::max(newest, std::optional(picture.state.stamp));
    time_of_grey[grey] = rig.store.capture_time_of(picture.state.stamp);
    EXPECT_EQ(time_of_grey[grey], std::llround(1e3 * (picture.state.stamp - all[0].state.stamp).seconds()));
    const std::vector<cv::Mat> pages = rig.store.read_pages(), times = rig.store.read_capture_times();
    for (const auto& [block, texels] : nearest) {
      const auto& [page, row, column] = block;
      const std::int32_t time = times[page].at<std::int32_t>(row, column);
      bool fits = false;
      for (const glm::ivec2& texel : texels) {
        const cv::Vec4b colour = pages[page].at<cv::Vec4b>(texel.y, texel.x);
        const auto from = time_of_grey.find(colour[1]);
        fits = fits || (colour[3] == 0 ? time == kNeverCaptured : from != time_of_grey.end() && from->second == time);
      }
      ++judged;
      wrong += fits ? 0 : 1;
      times_seen.insert(time);
    }
  }
  EXPECT_GT(judged, 2000);
  EXPECT_LE(wrong, judged / 500) << "of " << judged;
  EXPECT_GT(times_seen.size(), 6U) << "the pictures do not test much";
  EXPECT_GT(late_ones, 0);
}

TEST_F(CaptureTimesTest, AreShownWithTheTexturesTheyBelongTo) {
  const PolygonModel model = cluttered_room();
  BatchedRig direct(model, charts_), rig(model, charts_, options_, Publishing::buffered);
  TextureStore::Shown shown = rig.store.acquire();
  EXPECT_EQ(shown.capture_times, rig.store.capture_times());
  EXPECT_FALSE(shown.newest_capture);
  rig.store.release();
  const std::vector<CameraFrame> all = pictures(model, 8, 12);
  std::optional<Timestamp> newest;
  for (const CameraFrame& picture : all) {
    direct.pipeline.extract(picture);
    rig.pipeline.extract(picture);
    glFinish();
    newest = std::max(newest, std::optional(picture.state.stamp));
    shown = rig.store.acquire();
    EXPECT_EQ(shown.newest_capture, newest);
    EXPECT_EQ(shown.epoch, all[0].state.stamp);
    EXPECT_EQ(
        difference(TextureBytes::of(rig.store, shown.pages, shown.polygon_states, shown.capture_times), direct.bytes()),
        "");
    rig.store.release();
    EXPECT_EQ(direct.store.acquire().newest_capture, newest);
    direct.store.release();
  }
}

TEST_F(CaptureTimesTest, AreForgottenWithTheTextures) {
  const PolygonModel model = cluttered_room();
  BatchedRig rig(model, charts_);
  const auto known = [&] {
    int count = 0;
    for (const cv::Mat& page : rig.store.read_capture_times()) count += cv::countNonZero(page != kNeverCaptured);
    return count;
  };
  EXPECT_EQ(known(), 0);
  const CameraFrame picture = frame(model, plain(100));
  rig.pipeline.extract(picture);
  EXPECT_GT(known(), 10);
  rig.pipeline.clear();
  EXPECT_EQ(known(), 0);
  EXPECT_FALSE(rig.store.acquire().newest_capture);
  rig.store.release();
  rig.pipeline.extract(picture);
  EXPECT_GT(known(), 10);
  const auto contents = rig.store.read_as_shown();
  rig.store.write_pages(contents.pages, contents.states);
  EXPECT_EQ(known(), 0);
  EXPECT_FALSE(rig.store.acquire().newest_capture);
  rig.store.release();
}

TEST_F(CaptureTimesTest, ComeFromFrontsOnly) {
  // A valley of two quads in one chart; from one side the front of the farther and the back of the nearer is seen.
  RawMesh mesh;
  mesh.vertices = {{-0.1, -0.05, 1.97}, {-0.1, 0.05, 1.97}, {0, 0.05, 2},
                   {0, -0.05, 2},       {0.1, 0.05, 1.97},  {0.1, -0.05, 1.97}};
  mesh.faces = {{0, 1, 2, 3}, {3, 2, 4, 5}};
  const PolygonModel model = import_as_it_is(mesh);
  BatchedRig rig(model, charts_);
  ASSERT_EQ(rig.store.layout().groups.size(), 1U);
  rig.pipeline.extract(frame(model, plain(100), 1));
  CameraFrame aside = frame(model, plain(150), 2);
  aside.state.world_from_camera = looking_at({-0.3, 0, 1.96}, {0, 0, 1.985}, {0, -1, 0});
  const ExtractionStatistics statistics = rig.pipeline.extract(aside);
  ASSERT_EQ(statistics.polygons_visible, 1U);
  ASSERT_EQ(statistics.polygons_skipped_back_face, 1U);
  const cv::Mat texels = rig.store.read_pages()[0], times = rig.store.read_capture_times()[0];
  const ChartGroup& chart = rig.store.layout().groups[0];
  int first = 0;
  for (int y = chart.origin.y; y < chart.origin.y + chart.size.y; y += 16) {
    for (int x = chart.origin.x; x < chart.origin.x + chart.size.x; x += 16) {
      const std::int32_t time = times.at<std::int32_t>(y / 16, x / 16);
      cv::Mat new_ones;
      cv::inRange(texels(cv::Rect(x, y, 16, 16)), cv::Scalar(150, 150, 150, 255), cv::Scalar(150, 150, 150, 255),
                  new_ones);
      EXPECT_TRUE(time != 1000 || cv::countNonZero(new_ones) > 0) << x << ", " << y;
      first += time == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(first, 0);
}

TEST_F(CaptureTimesTest, AreThoseOfTheLastPictureOfAPolygonWithTheMethodOf2005) {
  const PolygonModel model = cluttered_room();
  ChartOptions charts = charts_;
  charts.group_polygons = false;
  TextureStore store(model, lay_out_charts(model, charts));
  const auto pipeline = make_extraction_pipeline(PipelineKind::per_polygon, store, charts, options_);
  pipeline->extract(frame(model, plain(100), 1));
  CameraFrame aside = frame(model, plain(150), 2.5);
  aside.state.world_from_camera.translation.x = 1;
  const ExtractionStatistics statistics = pipeline->extract(aside);
  std::size_t first = 0, second = 0;
  const std::vector<cv::Mat> times = store.read_capture_times();
  for (const Chart& chart : store.layout().charts) {
    const cv::Mat own =
        times[chart.page](cv::Rect(chart.origin.x / 16, chart.origin.y / 16, chart.size.x / 16, chart.size.y / 16));
    double least = 0, most = 0;
    cv::minMaxLoc(own, &least, &most);
    EXPECT_EQ(least, most);
    first += most == 0 ? 1 : 0;
    second += most == 1500 ? 1 : 0;
  }
  EXPECT_GT(first, 3U);
  EXPECT_EQ(second, statistics.charts_touched);
}

TEST_F(CaptureTimesTest, KeepToWhatTheirTypeHolds) {
  const PolygonModel model = cluttered_room();
  TextureStore store(model, lay_out_charts(model, charts_));
  EXPECT_EQ(store.capture_time_of(Timestamp{5'000'000'000}), 0);
  EXPECT_EQ(store.epoch(), Timestamp{5'000'000'000});
  EXPECT_EQ(store.capture_time_of(Timestamp{4'999'000'000}), -1);
  EXPECT_EQ(store.capture_time_of(Timestamp{std::numeric_limits<std::int64_t>::max()}), 2'147'000'000);
  EXPECT_EQ(store.capture_time_of(Timestamp{-4'000'000'000'000'000'000}), -2'147'000'000);
}

}  // namespace
}  // namespace foreview
