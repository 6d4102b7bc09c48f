// All textures of a picture change between two frames, never within one: DisplayLoop with the real pipelines and
// textures; only time is simulated, so that frames fall everywhere between slices.
#include <algorithm>
#include <cstring>
#include <memory>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/viewer/display_loop.h"
#include "foreview/viewer/live_scene.h"
#include "gpu/gl_test_fixture.h"
#include "viewer/simulated_loop.h"
#include "viewer/small_recording.h"

namespace foreview {
namespace {

using test::ms;
using test::SmallSite;

/// Slices take a random part of 1 to 4 ms, whatever they are, in time that the loop believes.
class RandomlySlow final : public LoopPlatform {
 public:
  RandomlySlow(OffscreenContext& display, OffscreenContext& extraction)
      : gl_([&] { display.make_current(); }, extraction) {}
  [[nodiscard]] Timestamp now() override { return time_; }
  void sleep_until(Timestamp when) override { time_ = std::max(time_, when); }
  void use_display_context() override { gl_.use_display_context(); }
  void in_extraction(const std::function<void()>& work) override { gl_.in_extraction(work); }
  void finish(const char* what) override {
    gl_.finish(what);
    time_ = time_ + Duration{std::uniform_int_distribution<std::int64_t>(1'000'000, 4'000'000)(random_)};
  }

 private:
  GlLoopPlatform gl_;
  Timestamp time_{1'000'000'000};
  std::mt19937 random_{7};
};

/// Gives one picture after the other.
class GivenPictures final : public FrameSource {
 public:
  std::vector<CameraFrame> pictures;
  std::size_t taken = 0;
  [[nodiscard]] std::optional<IncomingFrame> take() override {
    if (taken == pictures.size()) return std::nullopt;
    IncomingFrame frame;
    frame.frame = pictures[taken];
    frame.index = taken++;
    return frame;
  }
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp) const override { return std::nullopt; }
  [[nodiscard]] SourceStatus status() override { return {}; }
  [[nodiscard]] Timestamp time_at(Timestamp steady) const override { return steady; }
  [[nodiscard]] std::uint64_t generation() const override { return 0; }
  [[nodiscard]] std::size_t cameras() const override { return 1; }
  [[nodiscard]] std::optional<CameraModel> camera_model(std::size_t) const override { return std::nullopt; }
};

/// Blocks of all charts at all levels, states and exposure: what a frame can see.
struct Textures {
  std::vector<cv::Mat> blocks;
  std::vector<TextureStore::PolygonState> states;
  Exposure exposure;
};

Textures read(const TextureStore& store, const TextureStore::Shown& shown) {
  Textures textures;
  for (int level = 0; level < kChartLevels; ++level) {
    for (const ChartGroup& group : store.layout().groups) {
      const glm::ivec2 origin(group.origin.x >> level, group.origin.y >> level);
      cv::Mat block(std::max(1, group.size.y >> level), std::max(1, group.size.x >> level), CV_8UC4);
      glGetTextureSubImage(shown.pages, level, origin.x, origin.y, static_cast<GLint>(group.page), block.cols,
                           block.rows, 1, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(block.total() * 4),
                           block.data);
      textures.blocks.push_back(block);
    }
  }
  textures.states.resize(store.model().polygons().size());
  glGetNamedBufferSubData(shown.polygon_states, 0,
                          static_cast<GLsizeiptr>(textures.states.size() * sizeof(TextureStore::PolygonState)),
                          textures.states.data());
  glGetNamedBufferSubData(shown.exposure, 0, sizeof(Exposure), &textures.exposure);
  return textures;
}

bool same(const Textures& a, const Textures& b) {
  for (std::size_t i = 0; i < a.blocks.size(); ++i) {
    if (std::memcmp(a.blocks[i].data, b.blocks[i].data, a.blocks[i].total() * 4) != 0) return false;
  }
  return a.states == b.states && a.exposure == b.exposure;
}

class PublishingInLoop : public GlTest, public ::testing::WithParamInterface<PipelineKind> {
 public:
  ~PublishingInLoop() override { context().make_current(); }

 protected:
  static OffscreenContext::Options sharing() {
    OffscreenContext::Options options;
    options.debug = true;
    options.share_display = context().display();
    options.share_context = context().context();
    return options;
  }
  PublishingInLoop() : extraction_(sharing()) {
    install_debug_callback(true);
    context().make_current();
    site_.instants = 8;
    ImportOptions import;
    import.backdrop = false;
    model_ = std::make_unique<PolygonModel>(build_polygon_model(SmallSite::mesh(), import));
    charts_.texels_per_metre = 60;
    charts_.max_texels = 128;
    charts_.page_size = 512;
    charts_.group_polygons = GetParam() == PipelineKind::batched;
    options_.compensate_exposure = GetParam() == PipelineKind::batched;
    for (std::size_t i = 0; i < site_.instants; ++i) source_.pictures.push_back(frame(i));
  }
  [[nodiscard]] CameraFrame frame(std::size_t instant) const {
    CameraFrame result;
    result.camera = site_.camera;
    result.state.stamp = SmallSite::stamp(instant);
    result.picture = site_.render(0, result.state.stamp);
    result.state.world_from_camera = SmallSite::world_from_camera(0, result.state.stamp);
    for (const auto& part : model_->parts()) {
      result.state.world_from_part.push_back(part.name == "board" ? SmallSite::world_from_board(result.state.stamp)
                                                                  : Pose());
    }
    return result;
  }
  [[nodiscard]] TextureStore make_store(Publishing publishing) const {
    return {*model_, lay_out_charts(*model_, charts_), publishing};
  }
  [[nodiscard]] std::unique_ptr<ExtractionPipeline> make_pipeline(TextureStore& store) const {
    return make_extraction_pipeline(GetParam(), store, charts_, options_);
  }
  /// After each picture, as extract() gives them; and before the first.
  [[nodiscard]] std::vector<Textures> expected() const {
    TextureStore store = make_store(Publishing::direct);
    const auto pipeline = make_pipeline(store);
    const auto now = [&] {
      const Textures textures = read(store, store.acquire());
      store.release();
      return textures;
    };
    std::vector<Textures> result{now()};
    for (const CameraFrame& picture : source_.pictures) {
      static_cast<void>(pipeline->extract(picture));
      glFinish();
      result.push_back(now());
    }
    return result;
  }

  OffscreenContext extraction_;
  SmallSite site_;
  std::unique_ptr<PolygonModel> model_;
  ChartOptions charts_;
  ExtractionOptions options_;
  GivenPictures source_;
};

TEST_P(PublishingInLoop, EveryFrameShowsAllTexturesOfOnePicture) {
  const std::vector<Textures> pictures = expected();
  for (std::size_t i = 1; i < pictures.size(); ++i) ASSERT_FALSE(same(pictures[i - 1], pictures[i])) << i;
  RandomlySlow platform(context(), extraction_);
  std::unique_ptr<TextureStore> store;
  std::unique_ptr<ExtractionPipeline> pipeline;
  in_extraction_context(platform, [&] {
    store = std::make_unique<TextureStore>(*model_, lay_out_charts(*model_, charts_), Publishing::buffered);
    pipeline = make_pipeline(*store);
  });
  std::size_t frames_within = 0, slices = 0, slices_at_frame = 0, changes = 0;
  std::uint64_t last = 0;
  DisplayLoop* the_loop = nullptr;
  DisplayLoop::Callbacks callbacks;
  callbacks.slice_completed = [&](const SliceRecord&) { ++slices; };
  callbacks.draw = [&](const FrameMoment& moment) {
    const TextureStore::Shown shown = store->acquire();
    EXPECT_EQ(shown.picture, moment.picture);
    ASSERT_LT(moment.picture, pictures.size());
    EXPECT_TRUE(same(read(*store, shown), pictures[moment.picture]))
        << "frame " << moment.number << " mixes picture " << moment.picture << " with another";
    store->release();
    changes += moment.picture != last ? 1 : 0;
    last = moment.picture;
    frames_within += the_loop->is_extracting() && slices > slices_at_frame ? 1 : 0;
    slices_at_frame = slices;
  };
  DisplayLoop loop(platform, {.period = ms(9)}, *store, source_, callbacks);
  the_loop = &loop;
  loop.set_extraction(pipeline.get());
  while (last < source_.pictures.size() && loop.statistics().schedule.frames < 3000) ASSERT_TRUE(loop.run_frame());
  EXPECT_EQ(last, source_.pictures.size());
  EXPECT_GE(changes, source_.pictures.size() / 2);
  if (pipeline->slice_kinds().size() > 1) {
    EXPECT_GE(frames_within, 3 * source_.pictures.size()) << "hardly any frame was drawn within a picture";
  }
  in_extraction_context(platform, [&] {
    loop.set_extraction(nullptr);
    pipeline.reset();
    store.reset();
  });
}

TEST_P(PublishingInLoop, ExtractionIsReplacedWithoutLosingTextures) {
  LiveScene::Options options;
  options.pipeline = GetParam();
  options.extraction = options_;
  options.charts = charts_;
  options.debug = true;
  LiveScene scene(*model_, options, context().display(), context().context(), [] { context().make_current(); });
  const auto shown = [&] {
    const Textures textures = read(scene.store(), scene.store().acquire());
    scene.store().release();
    return textures;
  };
  const std::vector<Textures> pictures = expected();
  const auto extract = [&](const CameraFrame& frame, bool all) {
    in_extraction_context(scene.platform(), [&] {
      scene.extraction().begin(frame);
      scene.store().wait_for_free_set();
      do {
        const auto slice = scene.extraction().pending_slice();
        ASSERT_TRUE(slice);
        static_cast<void>(scene.extraction().run_slice(all ? slice->size : slice->least));
        scene.platform().finish("a slice");
      } while (all && scene.extraction().is_busy());
    });
  };
  extract(source_.pictures[0], true);
  EXPECT_TRUE(same(shown(), pictures[1]));
  ExtractionOptions other = options_;
  other.passes = 1;
  scene.replace_extraction(other);
  EXPECT_TRUE(same(shown(), pictures[1]));
  // One that was begun is finished.
  extract(source_.pictures[1], false);
  scene.replace_extraction(options_);
  EXPECT_FALSE(scene.extraction().is_busy());
  EXPECT_FALSE(same(shown(), pictures[1]));
  other.passes = 100;
  EXPECT_THROW(scene.replace_extraction(other), InputError);
  extract(source_.pictures[2], true);
}

/// Everything of a picture, at once.
void extract_whole(LiveScene& scene, const CameraFrame& frame) {
  in_extraction_context(scene.platform(), [&] {
    scene.extraction().begin(frame);
    scene.store().wait_for_free_set();
    while (scene.extraction().is_busy()) {
      const auto slice = scene.extraction().pending_slice();
      ASSERT_TRUE(slice);
      static_cast<void>(scene.extraction().run_slice(slice->size));
      scene.platform().finish("a slice");
    }
  });
}

Textures shown_by(LiveScene& scene) {
  Textures textures = read(scene.store(), scene.store().acquire());
  scene.store().release();
  return textures;
}

struct Change {
  const char* name;
  void (*make)(ExtractionOptions&);
};

TEST_P(PublishingInLoop, AParameterHoldsFromTheNextPictureOn) {
  LiveScene::Options options;
  options.pipeline = GetParam();
  options.extraction = options_;
  options.charts = charts_;
  options.debug = true;
  const auto two_pictures = [&](const Change* change) {
    LiveScene scene(*model_, options, context().display(), context().context(), [] { context().make_current(); });
    extract_whole(scene, source_.pictures[0]);
    const Textures first = shown_by(scene);
    if (change != nullptr) {
      ExtractionOptions changed = options_;
      change->make(changed);
      scene.replace_extraction(changed);
      EXPECT_TRUE(same(shown_by(scene), first)) << change->name << " changed what was there";
    }
    extract_whole(scene, source_.pictures[1]);
    return shown_by(scene);
  };
  const Textures unchanged = two_pictures(nullptr);
  EXPECT_TRUE(same(two_pictures(nullptr), unchanged)) << "the comparison means nothing";
  std::vector<Change> changes{
      {"artefacts", [](ExtractionOptions& o) { o.artefacts = ArtefactSuppression::none; }},
      {"passes", [](ExtractionOptions& o) { o.passes = 8; }},
      {"near plane", [](ExtractionOptions& o) { o.near_plane = 1.5; }},
  };
  // Exposure, alpha c and the size of small polygons matter in no scene as small as this; pipelines of their own are
  // tested for them.
  if (GetParam() == PipelineKind::per_polygon) {
    changes.push_back({"alternating", [](ExtractionOptions& o) { o.artefacts = ArtefactSuppression::alternating; }});
    changes.push_back({"progressive", [](ExtractionOptions& o) { o.artefacts = ArtefactSuppression::progressive; }});
    changes.push_back({"iterative", [](ExtractionOptions& o) { o.fill = HoleFilling::iterative; }});
    changes.push_back({"no filling", [](ExtractionOptions& o) { o.fill = HoleFilling::none; }});
  }
  for (const Change& change : changes) {
    EXPECT_FALSE(same(two_pictures(&change), unchanged)) << change.name << " has no effect";
  }
}

TEST_P(PublishingInLoop, PreparedBesideTheDisplayItShowsNothingSeenAndThenTheSame) {
  LiveScene::Options options;
  options.pipeline = GetParam();
  options.extraction = options_;
  options.charts = charts_;
  options.debug = true;
  options.beside_display = true;
  LiveScene scene(*model_, options, context().display(), context().context(), [] { context().make_current(); });
  // Whether it is ready yet or not.
  const TextureStore::Shown shown = scene.store().acquire();
  EXPECT_EQ(shown.picture, 0U);
  EXPECT_TRUE(glIsTexture(shown.pages) == GL_TRUE && glIsTexture(shown.capture_times) == GL_TRUE);
  std::vector<TextureStore::PolygonState> states(model_->polygons().size());
  glGetNamedBufferSubData(shown.polygon_states, 0,
                          static_cast<GLsizeiptr>(states.size() * sizeof(TextureStore::PolygonState)), states.data());
  scene.store().release();
  for (const TextureStore::PolygonState& state : states) EXPECT_EQ(state.seen, 0);
  extract_whole(scene, source_.pictures[0]);  // waits until it is ready
  EXPECT_TRUE(scene.is_ready());
  EXPECT_TRUE(same(shown_by(scene), expected()[1]));
}

TEST_P(PublishingInLoop, WhatFailsBesideTheDisplayIsTold) {
  LiveScene::Options options;
  options.pipeline = GetParam();
  options.charts = charts_;
  options.initial_textures = "/there/are/no/textures";
  options.beside_display = true;
  LiveScene scene(*model_, options, context().display(), context().context(), [] { context().make_current(); });
  EXPECT_THROW(in_extraction_context(scene.platform(), [] {}), InputError);
  EXPECT_THROW(static_cast<void>(scene.is_ready()), InputError);
}

INSTANTIATE_TEST_SUITE_P(Pipelines, PublishingInLoop,
                         ::testing::Values(PipelineKind::batched, PipelineKind::per_polygon),
                         [](const auto& of) { return of.param == PipelineKind::batched ? "Batched" : "PerPolygon"; });

}  // namespace
}  // namespace foreview
