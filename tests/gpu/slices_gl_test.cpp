// Extraction in slices (ExtractionPipeline::begin() and run_slice()): the same textures as at once, however it is cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "foreview/scene/errors.h"
#include "gpu/batched_scene.h"

namespace foreview {
namespace {

/// How much of a slice to run.
using Cut = std::function<double(const SliceKind&, const ExtractionSlice&)>;

double all_of_it(const SliceKind& /*kind*/, const ExtractionSlice& slice) {
  return slice.size;
}
double least_of_it(const SliceKind& /*kind*/, const ExtractionSlice& slice) {
  return slice.least;
}
/// Sometimes everything, sometimes nearly nothing, mostly something between.
Cut pieces_at_random(unsigned seed) {
  return [random = std::mt19937(seed)](const SliceKind& /*kind*/, const ExtractionSlice& slice) mutable {
    const double share = static_cast<double>(random()) / 4294967296.0;
    return random() % 4 == 0 ? slice.size * 2 : slice.size * share * share;
  };
}

struct Pieces {
  std::size_t slices = 0;
  bool finished = false;  ///< else it could not go on
};
/// Runs what was begun, but no more than `most` slices, finishing each.
Pieces run(ExtractionPipeline& pipeline, const Cut& cut, std::size_t most = 1000000) {
  Pieces result;
  while (result.slices < most) {
    const auto slice = pipeline.pending_slice();
    if (!slice) break;
    EXPECT_LT(slice->kind, pipeline.slice_kinds().size());
    if (slice->kind >= pipeline.slice_kinds().size()) break;
    EXPECT_GT(slice->size, 0);
    EXPECT_GT(slice->least, 0);
    EXPECT_LE(slice->least, slice->size);
    const double asked = cut(pipeline.slice_kinds()[slice->kind], *slice);
    const double done = pipeline.run_slice(asked);
    EXPECT_GT(done, 0);
    EXPECT_LE(done, std::max(asked, slice->least) * (1 + 1e-9)) << pipeline.slice_kinds()[slice->kind].name;
    EXPECT_LE(done, slice->size * (1 + 1e-9)) << pipeline.slice_kinds()[slice->kind].name;
    glFinish();
    ++result.slices;
  }
  result.finished = !pipeline.is_busy();
  return result;
}
Pieces extract_in_slices(ExtractionPipeline& pipeline, const CameraFrame& frame, const Cut& cut) {
  pipeline.begin(frame);
  return run(pipeline, cut);
}

void expect_same(const ExtractionStatistics& a, const ExtractionStatistics& b) {
  EXPECT_EQ(a.polygons_visible, b.polygons_visible);
  EXPECT_EQ(a.polygons_skipped_back_face, b.polygons_skipped_back_face);
  EXPECT_EQ(a.polygons_skipped_outside, b.polygons_skipped_outside);
  EXPECT_EQ(a.polygons_skipped_too_small, b.polygons_skipped_too_small);
  EXPECT_EQ(a.polygons_exempt_small, b.polygons_exempt_small);
  EXPECT_EQ(a.charts_touched, b.charts_touched);
}

class SlicesTest : public BatchedTest {
 protected:
  /// Extracts the pictures at once and in slices, and compares after each.
  void compare(PipelineKind kind, Publishing publishing, const Cut& cut, int count, unsigned seed) const {
    const PolygonModel model = cluttered_room();
    ChartOptions charts = charts_;
    charts.group_polygons = kind == PipelineKind::batched;
    TextureStore whole_store(model, lay_out_charts(model, charts), publishing);
    TextureStore sliced_store(model, lay_out_charts(model, charts), publishing);
    const auto whole = make_extraction_pipeline(kind, whole_store, charts, options_);
    const auto sliced = make_extraction_pipeline(kind, sliced_store, charts, options_);
    for (const CameraFrame& picture : pictures(model, count, seed)) {
      const ExtractionStatistics expected = whole->extract(picture);
      glFinish();
      const Pieces pieces = extract_in_slices(*sliced, picture, cut);
      ASSERT_TRUE(pieces.finished);
      ASSERT_FALSE(sliced->pending_slice());
      ASSERT_EQ(sliced_store.pictures_ended(), whole_store.pictures_ended());
      ASSERT_EQ(difference(TextureBytes::of(whole_store), TextureBytes::of(sliced_store)), "")
          << "picture " << whole_store.pictures_ended();
      expect_same(expected, sliced->statistics());
    }
  }
};

TEST_F(SlicesTest, GiveTheSameTexturesPolygonByPolygon) {
  compare(PipelineKind::per_polygon, Publishing::direct, all_of_it, 3, 1);
  compare(PipelineKind::per_polygon, Publishing::buffered, all_of_it, 3, 2);
}

TEST_F(SlicesTest, GiveTheSameTexturesHoweverTheyAreCut) {
  for (const Publishing publishing : {Publishing::direct, Publishing::buffered}) {
    for (const bool compensating : {false, true}) {
      options_.compensate_exposure = compensating;
      compare(PipelineKind::batched, publishing, all_of_it, 8, 3);
      compare(PipelineKind::batched, publishing, least_of_it, 8, 4);
      compare(PipelineKind::batched, publishing, pieces_at_random(5), 8, 5);
    }
  }
}

TEST_F(SlicesTest, RefuseWhatCannotBeExtractedAtTheBeginning) {
  const PolygonModel model = cluttered_room();
  for (const PipelineKind kind : {PipelineKind::batched, PipelineKind::per_polygon}) {
    ChartOptions charts = charts_;
    charts.group_polygons = kind == PipelineKind::batched;
    TextureStore store(model, lay_out_charts(model, charts));
    const auto pipeline = make_extraction_pipeline(kind, store, charts, options_);
    CameraFrame picture = frame(model, plain(100));
    picture.picture = picture.picture(cv::Rect(0, 0, 10, 10)).clone();
    EXPECT_THROW(pipeline->begin(picture), InputError);
    picture = frame(model, plain(100));
    picture.state.world_from_part.pop_back();
    EXPECT_THROW(pipeline->begin(picture), InputError);
    EXPECT_FALSE(pipeline->is_busy());
    EXPECT_FALSE(pipeline->pending_slice());
    EXPECT_TRUE(extract_in_slices(*pipeline, frame(model, plain(100)), all_of_it).finished);
  }
}

}  // namespace
}  // namespace foreview
