// Extraction in slices (ExtractionPipeline::begin() and run_slice()): the same textures as at once, however it is cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "foreview/gpu/batched/page_targets.h"
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
/// What others may do to the context between two slices.
void disturb_context() {
  for (const GLenum capability : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST}) glEnable(capability);
  glScissor(3, 5, 7, 9);
  glDepthFunc(GL_NEVER);
  glDepthMask(GL_FALSE);
  glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
  glBlendFunc(GL_ONE, GL_ONE);
  glViewport(1, 2, 3, 4);
  glUseProgram(0);
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  for (GLuint unit = 0; unit < 16; ++unit) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, unit, 0);
  for (GLuint unit = 0; unit < 4; ++unit) {
    glBindTextureUnit(unit, 0);
    glBindBufferBase(GL_UNIFORM_BUFFER, unit, 0);
  }
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

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
    disturb_context();
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
  EXPECT_EQ(a.texels_written, b.texels_written);
  EXPECT_EQ(a.texels_filled, b.texels_filled);
  EXPECT_EQ(a.texels_observed, b.texels_observed);
}

class SlicesTest : public BatchedTest {
 protected:
  /// Extracts the pictures at once and in slices, and compares after each.
  void compare(PipelineKind kind, Publishing publishing, const Cut& cut, int count, unsigned seed,
               bool counting = false, PageCopier::Method copying = PageCopier::Method::commands) const {
    const PolygonModel model = cluttered_room();
    ChartOptions charts = charts_;
    charts.group_polygons = kind == PipelineKind::batched;
    TextureStore whole_store(model, lay_out_charts(model, charts), publishing);
    TextureStore sliced_store(model, lay_out_charts(model, charts), publishing);
    const auto whole = make_extraction_pipeline(kind, whole_store, charts, options_);
    const auto sliced = make_extraction_pipeline(kind, sliced_store, charts, options_);
    whole->set_counting(counting);
    sliced->set_counting(counting);
    if (publishing == Publishing::buffered) sliced_store.set_copy_method(copying);
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

TEST_F(SlicesTest, AreCountedAsAWhole) {
  compare(PipelineKind::batched, Publishing::direct, pieces_at_random(6), 6, 6, true);
}

TEST_F(SlicesTest, GiveTheSameTexturesWithoutSuppression) {
  options_.artefacts = ArtefactSuppression::none;
  compare(PipelineKind::batched, Publishing::direct, pieces_at_random(7), 6, 7);
  options_.artefacts = ArtefactSuppression::diamond;
  options_.passes = 4;
  compare(PipelineKind::batched, Publishing::direct, pieces_at_random(8), 6, 8);
}

TEST_F(SlicesTest, GiveTheSameTexturesHoweverSetsAreCopied) {
  compare(PipelineKind::batched, Publishing::buffered, least_of_it, 8, 9, false, PageCopier::Method::dispatch);
  compare(PipelineKind::batched, Publishing::buffered, pieces_at_random(9), 8, 10, false, PageCopier::Method::commands);
}

TEST_F(SlicesTest, GiveTheSameTexturesWhereLayersAreDrawnOneByOne) {
  batched::forbid_drawing_layers(true);
  compare(PipelineKind::batched, Publishing::direct, pieces_at_random(11), 6, 11);
  batched::forbid_drawing_layers(false);
}

TEST_F(SlicesTest, GiveTheSameTexturesAfterOthersWereAdopted) {
  const PolygonModel model = cluttered_room();
  const std::vector<CameraFrame> all = pictures(model, 6, 12);
  BatchedRig source(model, charts_), whole(model, charts_), sliced(model, charts_);
  source.pipeline.extract(all[0]);
  for (BatchedRig* rig : {&whole, &sliced}) {
    rig->store.write_pages(source.store.read_pages(), source.store.read_polygon_states());
    rig->pipeline.adopt_store();
  }
  for (std::size_t i = 1; i < all.size(); ++i) {
    whole.pipeline.extract(all[i]);
    ASSERT_TRUE(extract_in_slices(sliced.pipeline, all[i], pieces_at_random(12)).finished);
    ASSERT_EQ(difference(whole.bytes(), sliced.bytes()), "") << i;
  }
}

TEST_F(SlicesTest, AreFewWhereTheyMayBeLargeAndManyWhereTheyMustBeSmall) {
  const PolygonModel model = cluttered_room();
  BatchedRig rig(model, charts_);
  const CameraFrame picture = frame(model, plain(100));
  EXPECT_LE(extract_in_slices(rig.pipeline, picture, all_of_it).slices, rig.pipeline.slice_kinds().size());
  EXPECT_GE(extract_in_slices(rig.pipeline, picture, least_of_it).slices, 100U);
}

TEST_F(SlicesTest, LeaveNoTraceOfAPictureAbandonedHalfWay) {
  const PolygonModel model = cluttered_room();
  options_.compensate_exposure = true;
  std::mt19937 random(13);
  for (const Publishing publishing : {Publishing::direct, Publishing::buffered}) {
    BatchedRig used(model, charts_, options_, publishing);
    const std::vector<CameraFrame> all = pictures(model, 40, 13);
    // Textures for pictures grow with the largest so far, which samples' last bits show.
    const CameraFrame& largest =
        *std::ranges::max_element(all, {}, [](const CameraFrame& picture) { return picture.camera.width; });
    used.pipeline.extract(largest);
    used.pipeline.clear();
    std::size_t abandoned_late = 0;
    for (std::size_t round = 0; round < 12; ++round) {
      // Some pictures, then one that ends somewhere.
      for (std::size_t i = 0; i < round % 3; ++i) {
        ASSERT_TRUE(extract_in_slices(used.pipeline, all[2 * round + i], pieces_at_random(13)).finished);
      }
      const TextureStore::Shown before = used.store.acquire();
      const TextureBytes shown =
          TextureBytes::of(used.store, before.pages, before.polygon_states, before.capture_times);
      used.pipeline.begin(all[2 * round + 5]);
      const Pieces pieces = run(used.pipeline, least_of_it, 1 + random() % 180);
      abandoned_late += pieces.slices > 100 && !pieces.finished ? 1 : 0;
      if (publishing == Publishing::buffered) {
        EXPECT_EQ(
            difference(TextureBytes::of(used.store, before.pages, before.polygon_states, before.capture_times), shown),
            "");
      }
      used.store.release();
      used.pipeline.clear();
      ASSERT_FALSE(used.pipeline.is_busy());
      ASSERT_FALSE(used.pipeline.pending_slice());
      BatchedRig fresh(model, charts_, options_, publishing);
      fresh.pipeline.extract(largest);
      fresh.pipeline.clear();
      ASSERT_EQ(difference(used.bytes(), fresh.bytes()), "") << round;
      glFinish();
      const TextureStore::Shown cleared = used.store.acquire();
      EXPECT_EQ(difference(TextureBytes::of(used.store, cleared.pages, cleared.polygon_states, cleared.capture_times),
                           fresh.bytes()),
                "");
      used.store.release();
      // As many as there are sets, so that each is used again.
      for (std::size_t i = 0; i < 3; ++i) {
        const CameraFrame& picture = all[2 * round + 10 + i];
        fresh.pipeline.extract(picture);
        ASSERT_TRUE(extract_in_slices(used.pipeline, picture, pieces_at_random(14)).finished);
        ASSERT_EQ(difference(used.bytes(), fresh.bytes()), "") << round << ", " << i;
      }
    }
    EXPECT_GE(abandoned_late, 2U);
  }
}

TEST_F(SlicesTest, LeaveNoTraceOfExposuresCountedHalfWay) {
  const PolygonModel model = cluttered_room();
  options_.compensate_exposure = true;
  charts_.texels_per_metre = 250;
  charts_.max_texels = 256;
  charts_.page_size = 512;
  BatchedRig used(model, charts_, options_), fresh(model, charts_, options_);
  used.pipeline.extract(frame(model, plain(100), 1));
  used.pipeline.begin(frame(model, plain(120), 2));
  // Until all samples are counted, but not yet judged.
  const auto is_counted = [&](const ExtractionSlice& slice) {
    return std::string_view(used.pipeline.slice_kinds()[slice.kind].name) == "patches" && slice.size < 1.05;
  };
  for (auto slice = used.pipeline.pending_slice(); slice && !is_counted(*slice);
       slice = used.pipeline.pending_slice()) {
    static_cast<void>(used.pipeline.run_slice(slice->least));
    glFinish();
  }
  ASSERT_TRUE(used.pipeline.is_busy());
  used.pipeline.clear();
  for (int i = 0; i < 3; ++i) {
    const CameraFrame picture = frame(model, plain(100 + 15 * i), i + 3);
    used.pipeline.extract(picture);
    fresh.pipeline.extract(picture);
    ASSERT_EQ(difference(used.bytes(), fresh.bytes()), "") << i;
    EXPECT_EQ(used.store.read_exposure().shown[0], fresh.store.read_exposure().shown[0]);
    if (i > 0) {
      EXPECT_GT(fresh.store.read_exposure().shown[0], 1.05F) << "too few samples for this test";
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
