#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <opencv2/core.hpp>
#include <random>
#include <set>
#include <thread>

#include "foreview/gpu/texture_store.h"
#include "gpu/extraction_scene.h"
#include "gpu/gl_test_fixture.h"
#include "gpu/test_model.h"

namespace foreview {
namespace {

using State = TextureStore::PolygonState;
using Colour = std::array<GLubyte, 4>;

/// Different in every channel for neighbouring pictures.
Colour colour_of(std::uint64_t picture) {
  return {static_cast<GLubyte>(picture), static_cast<GLubyte>(3 * picture), static_cast<GLubyte>(255 - picture), 255};
}

std::vector<std::uint32_t> all_polygons(const TextureStore& store) {
  std::vector<std::uint32_t> all(store.model().polygons().size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

/// The charts in one colour, all levels, and their polygons' states.
void paint(TextureStore& store, const std::vector<std::uint32_t>& polygons, const Colour& colour) {
  const State state{static_cast<float>(colour[0]), static_cast<float>(colour[1]), static_cast<float>(colour[2]), 1.0F};
  for (const std::uint32_t polygon : polygons) {
    const Chart& chart = store.layout().charts[polygon];
    glClearTexSubImage(store.pages(), 0, chart.origin.x, chart.origin.y, static_cast<GLint>(chart.page), chart.size.x,
                       chart.size.y, 1, GL_RGBA, GL_UNSIGNED_BYTE, colour.data());
    glNamedBufferSubData(store.polygon_states(), static_cast<GLintptr>(polygon * sizeof state), sizeof state, &state);
  }
  store.update_levels(polygons);
}

cv::Mat read_level(const ChartLayout& layout, GLuint pages, int level, std::uint32_t page) {
  const int size = layout.page_size >> level;
  cv::Mat picture(size, size, CV_8UC4);
  glGetTextureSubImage(pages, level, 0, 0, static_cast<GLint>(page), size, size, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                       size * size * 4, picture.data);
  return picture;
}

cv::Mat part_of(const cv::Mat& page, const Chart& chart, int level) {
  return page(cv::Rect(chart.origin.x >> level, chart.origin.y >> level, chart.size.x >> level, chart.size.y >> level));
}

std::vector<State> read_states(GLuint buffer, std::size_t polygons) {
  std::vector<State> states(polygons);
  glGetNamedBufferSubData(buffer, 0, static_cast<GLsizeiptr>(polygons * sizeof(State)), states.data());
  return states;
}

/// Charts at all levels and states, all bytes. Returns what differs first, or nothing.
std::string difference(const TextureStore& store, GLuint pages, GLuint states, const TextureStore& expected) {
  const ChartLayout& layout = store.layout();
  for (int level = 0; level < kChartLevels; ++level) {
    std::vector<cv::Mat> got, wanted;
    for (std::uint32_t page = 0; page < layout.pages; ++page) {
      got.push_back(read_level(layout, pages, level, page));
      wanted.push_back(read_level(layout, expected.pages(), level, page));
    }
    for (std::size_t i = 0; i < layout.charts.size(); ++i) {
      const Chart& chart = layout.charts[i];
      if (cv::norm(part_of(got[chart.page], chart, level), part_of(wanted[chart.page], chart, level), cv::NORM_INF) !=
          0) {
        return "chart " + std::to_string(i) + " level " + std::to_string(level);
      }
    }
  }
  const auto got = read_states(states, layout.charts.size());
  const auto wanted = read_states(expected.polygon_states(), layout.charts.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    if (got[i] != wanted[i]) return "state " + std::to_string(i);
  }
  return {};
}

/// Work that keeps the GPU busy for a good part of a second behind the caller's back.
class BusyWork {
 public:
  BusyWork()
      : program_(make()),
        target_(make_texture_2d(GL_RGBA8, 256, 256)),
        framebuffer_(make_framebuffer(target_.id())),
        vao_(GlVertexArray::create()) {
    // As much as this GPU needs that long for.
    for (auto took = std::chrono::steady_clock::duration::zero(); took < std::chrono::milliseconds(200);) {
      rounds_ *= 2;
      const auto start = std::chrono::steady_clock::now();
      static_cast<void>(issue());
      glFinish();
      took = std::chrono::steady_clock::now() - start;
    }
  }
  /// Issues it; the fence behind it.
  [[nodiscard]] GlFence issue() const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, 256, 256);
    glUseProgram(program_.id());
    glBindVertexArray(vao_.id());
    glUniform1i(0, rounds_);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return GlFence::insert();
  }

 private:
  static GlProgram make() {
    const auto compile = [](GLenum type, const char* text) {
      const GLuint shader = glCreateShader(type);
      glShaderSource(shader, 1, &text, nullptr);
      glCompileShader(shader);
      return shader;
    };
    const GLuint vertex = compile(GL_VERTEX_SHADER,
                                  "#version 450 core\nvoid main() {\n"
                                  "  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, "
                                  "0.0, 1.0);\n}\n");
    const GLuint fragment = compile(GL_FRAGMENT_SHADER,
                                    "#version 450 core\nout vec4 colour;\nlayout(location = 0) uniform int rounds;\n"
                                    "void main() {\n  float sum = gl_FragCoord.x;\n"
                                    "  for (int i = 0; i < rounds; ++i) sum = sin(sum) + 1.7 * cos(sum * sum);\n"
                                    "  colour = vec4(sum);\n}\n");
    GlProgram program(glCreateProgram());
    glAttachShader(program.id(), vertex);
    glAttachShader(program.id(), fragment);
    glLinkProgram(program.id());
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    return program;
  }
  int rounds_ = 200;
  GlProgram program_;
  GlTexture target_;
  GlFramebuffer framebuffer_;
  GlVertexArray vao_;
};

/// The fixture's context is the display's.
class PublishingTest : public GlTest {
 public:
  ~PublishingTest() override { context().make_current(); }

 protected:
  PublishingTest() : extraction_(sharing()) {
    install_debug_callback(true);
    context().make_current();
  }
  static OffscreenContext::Options sharing() {
    OffscreenContext::Options options;
    options.debug = true;
    options.share_display = context().display();
    options.share_context = context().context();
    return options;
  }
  static void display() { context().make_current(); }
  void extraction() { extraction_.make_current(); }
  /// A picture of one colour, begun to finished.
  void publish(TextureStore& store, const Colour& colour) {
    extraction();
    store.wait_for_free_set();
    ASSERT_TRUE(store.begin_picture());
    paint(store, all_polygons(store), colour);
    store.end_picture(all_polygons(store));
    glFinish();
  }
  /// A picture that touches nothing. (Barriers may wait for everything on a software rasteriser; without anything to
  /// bring up to date there is none.)
  void publish_nothing(TextureStore& store) {
    extraction();
    store.wait_for_free_set();
    ASSERT_TRUE(store.begin_picture());
    store.end_picture({});
  }
  /// Shown in a frame that is done at once.
  static std::uint64_t shown_picture(const TextureStore& store) {
    display();
    const std::uint64_t picture = store.acquire().picture;
    store.release();
    glFinish();
    return picture;
  }

  OffscreenContext extraction_;
};

/// Of the batched pipeline.
constexpr std::size_t kSlicesBeforeTheSet = 4;

const std::vector<glm::ivec2> kMixedSizes{{16, 16}, {32, 16}, {16, 48}, {64, 64}, {16, 16}};

TEST_F(PublishingTest, AllTexturesOfAPictureChangeAtOnce) {
  const PolygonModel model = rows_of_quads({60});
  TextureStore store(model, tight_layout(model, {{64, 64}, {128, 64}, {32, 96}}, 512), Publishing::buffered);
  const ChartLayout& layout = store.layout();
  constexpr std::uint64_t kPictures = 200;
  std::atomic<bool> stop = false;
  context().release_current();
  std::thread extractor([&] {
    extraction();
    for (std::uint64_t k = 1; k <= kPictures && !stop; ++k) {
      store.wait_for_free_set();
      if (!store.begin_picture()) {
        ADD_FAILURE() << "no set was free after waiting for one";
        break;
      }
      paint(store, all_polygons(store), colour_of(k));
      store.end_picture(all_polygons(store));
    }
    extraction_.release_current();
  });

  // Three frames in flight, each with a copy of all that it saw: a flipped blit is drawn, not merely copied.
  context().make_current();
  struct Frame {
    GlTexture seen;
    std::vector<GlFramebuffer> targets;
    GlBuffer states;
    std::uint64_t picture = 0;
  };
  const auto pages = static_cast<int>(layout.pages);
  std::array<Frame, 3> frames;
  for (Frame& frame : frames) {
    frame.seen = make_texture_2d_array(GL_RGBA8, layout.page_size, layout.page_size, pages);
    for (int page = 0; page < pages; ++page) frame.targets.push_back(make_layer_framebuffer(frame.seen.id(), page));
    frame.states = GlBuffer::create();
    glNamedBufferStorage(frame.states.id(), static_cast<GLsizeiptr>(layout.charts.size() * sizeof(State)), nullptr, 0);
  }
  const GlFramebuffer source = GlFramebuffer::create();
  std::uint64_t last = 0, changes = 0;
  bool failed = false;
  for (std::size_t i = 0; last < kPictures && !failed; ++i) {
    Frame& frame = frames[i % frames.size()];
    if (i >= frames.size()) {
      for (int page = 0; page < pages; ++page) {
        cv::Mat picture = read_level(layout, frame.seen.id(), 0, static_cast<std::uint32_t>(page));
        cv::flip(picture, picture, 0);
        const Colour c = frame.picture == 0 ? Colour{} : colour_of(frame.picture);
        for (const Chart& chart : layout.charts) {
          if (static_cast<int>(chart.page) != page) continue;
          const cv::Mat part = part_of(picture, chart, 0);
          failed = failed ||
                   cv::norm(part, cv::Mat(part.size(), CV_8UC4, cv::Scalar(c[0], c[1], c[2], c[3])), cv::NORM_INF) != 0;
        }
      }
      for (const State& state : read_states(frame.states.id(), layout.charts.size())) {
        const float red = frame.picture == 0 ? 0.5F : static_cast<float>(colour_of(frame.picture)[0]);
        failed = failed || state.red != red;
      }
      EXPECT_FALSE(failed) << "frame " << i - frames.size() << " mixes picture " << frame.picture << " with another";
      EXPECT_GE(frame.picture, last);
      if (frame.picture != last) ++changes;
      last = frame.picture;
    }
    const TextureStore::Shown shown = store.acquire();
    frame.picture = shown.picture;
    for (int page = 0; page < pages; ++page) {
      glNamedFramebufferTextureLayer(source.id(), GL_COLOR_ATTACHMENT0, shown.pages, 0, page);
      glBlitNamedFramebuffer(source.id(), frame.targets[static_cast<std::size_t>(page)].id(), 0, 0, layout.page_size,
                             layout.page_size, 0, layout.page_size, layout.page_size, 0, GL_COLOR_BUFFER_BIT,
                             GL_NEAREST);
    }
    glCopyNamedBufferSubData(shown.polygon_states, frame.states.id(), 0, 0,
                             static_cast<GLsizeiptr>(layout.charts.size() * sizeof(State)));
    store.release();
  }
  stop = true;
  extractor.join();
  EXPECT_GE(changes, 3U);
}

class CopyMethods : public PublishingTest, public ::testing::WithParamInterface<PageCopier::Method> {};

TEST_P(CopyMethods, NothingIsLostWhicheverSetAPictureIsWrittenTo) {
  const PolygonModel model = rows_of_quads({40});
  extraction();
  ChartLayout layout = tight_layout(model, kMixedSizes, 128);
  // Two polygons that share a block.
  layout.charts[7] = layout.charts[6];
  TextureStore direct(model, layout), store(model, layout, Publishing::buffered);
  store.set_copy_method(GetParam());
  std::mt19937 random(3);
  const auto below = [&](std::size_t bound) { return static_cast<std::uint32_t>(random() % bound); };
  std::set<GLuint> sets_seen;
  bool holding = false;
  std::uint64_t pictures = 0;
  for (int step = 1; step <= 300; ++step) {
    const std::uint32_t kind = below(20);
    const auto both = [&](const auto& change) {
      change(direct);
      change(store);
    };
    extraction();
    if (kind == 0) {
      both([](TextureStore& s) { s.clear(); });
    } else if (kind == 1) {
      std::vector<cv::Mat> pages;
      for (std::uint32_t page = 0; page < layout.pages; ++page) {
        pages.emplace_back(128, 128, CV_8UC4);
        cv::randu(pages.back(), 0, 256);
      }
      std::vector<State> states(40);
      for (State& state : states) state = {static_cast<float>(below(100)), 0.1F, 0.2F, below(2) == 0 ? 1.0F : 0.5F};
      both([&](TextureStore& s) { s.write_pages(pages, states); });
    } else if (kind == 2) {
      both([](TextureStore& s) { s.spread_to_never_seen(); });
    } else {
      // Mostly a few charts, as a camera sees; sometimes none, sometimes one twice.
      std::vector<std::uint32_t> touched;
      for (std::uint32_t i = below(6); i > 0; --i) touched.push_back(below(40));
      std::vector<std::uint32_t> distinct = touched;
      std::ranges::sort(distinct);
      distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
      const bool clears = kind == 3;
      both([&](TextureStore& s) {
        s.wait_for_free_set();
        ASSERT_TRUE(s.begin_picture());
        if (clears) s.clear();
        paint(s, distinct, colour_of(static_cast<std::uint64_t>(step)));
        s.spread_to_never_seen(TextureStore::kRimsPerPicture);
        s.end_picture(touched);
      });
      ++pictures;
    }
    ASSERT_EQ(difference(store, store.pages(), store.polygon_states(), direct), "") << "step " << step;
    EXPECT_EQ(store.pictures_ended(), pictures);
    glFinish();

    // The display comes and goes, and often holds one set over several pictures.
    display();
    if (holding && below(2) == 0) {
      store.release();
      holding = false;
    }
    if (!holding && below(2) == 0) {
      const TextureStore::Shown shown = store.acquire();
      holding = true;
      sets_seen.insert(shown.pages);
      EXPECT_EQ(shown.picture, pictures);
      ASSERT_EQ(difference(store, shown.pages, shown.polygon_states, direct), "") << "shown at step " << step;
    }
    glFinish();
  }
  if (holding) store.release();
  EXPECT_EQ(sets_seen.size(), 3U);
}

TEST_P(CopyMethods, LargePagesAreCopiedToo) {
  // Many charts on a page, which commands copy as whole coarse levels; and a page with one chart only.
  const PolygonModel model = rows_of_quads({1025});
  extraction();
  const ChartLayout layout = tight_layout(model, {{32, 32}}, 1024);
  ASSERT_EQ(layout.pages, 2U);
  TextureStore direct(model, layout), store(model, layout, Publishing::buffered);
  store.set_copy_method(GetParam());
  for (std::uint32_t step = 1; step <= 6; ++step) {
    std::vector<std::uint32_t> touched;
    for (std::uint32_t i = step; i < 1025; i += step % 2 == 0 ? 3 : 101) touched.push_back(i);
    if (step == 3) touched.push_back(1024);
    for (TextureStore* s : {&direct, &store}) {
      s->wait_for_free_set();
      ASSERT_TRUE(s->begin_picture());
      paint(*s, touched, colour_of(step));
      s->end_picture(touched);
    }
    ASSERT_EQ(difference(store, store.pages(), store.polygon_states(), direct), "") << step;
  }
}

std::string name_of(const ::testing::TestParamInfo<PageCopier::Method>& tested) {
  return tested.param == PageCopier::Method::commands ? "Commands" : "Dispatch";
}

INSTANTIATE_TEST_SUITE_P(Publishing, CopyMethods,
                         ::testing::Values(PageCopier::Method::commands, PageCopier::Method::dispatch), name_of);

TEST_F(PublishingTest, UnfinishedPictureIsNeitherShownNorWaitedFor) {
  const PolygonModel model = rows_of_quads({5});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128), Publishing::buffered);
  publish(store, colour_of(1));
  EXPECT_EQ(shown_picture(store), 1U);
  extraction();
  const BusyWork work;
  store.wait_for_free_set();
  ASSERT_TRUE(store.begin_picture());
  paint(store, all_polygons(store), colour_of(2));
  const GlFence busy = work.issue();
  store.end_picture(all_polygons(store));
  display();
  for (int frame = 0; frame < 3; ++frame) {
    const std::uint64_t picture = store.acquire().picture;
    store.release();
    ASSERT_FALSE(busy.has_passed()) << "the work is too quick for this test, or acquire() waited for it";
    EXPECT_EQ(picture, 1U);
  }
  extraction();
  glFinish();
  EXPECT_EQ(shown_picture(store), 2U);
}

TEST_F(PublishingTest, NoPictureBeginsWhileTheDisplayReadsAllOtherSets) {
  const PolygonModel model = rows_of_quads({5});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128), Publishing::buffered);
  const BusyWork work;
  EXPECT_EQ(store.acquire().picture, 0U);
  publish_nothing(store);
  glFinish();
  display();
  const GlFence busy = work.issue();
  store.release();
  EXPECT_EQ(store.acquire().picture, 1U);
  publish_nothing(store);
  // One set has a frame in flight, one is held, one is the newest.
  ASSERT_FALSE(store.begin_picture());
  ASSERT_FALSE(busy.has_passed()) << "the work is too quick for this test, or begin_picture() waited for it";
  store.wait_for_free_set();
  EXPECT_TRUE(busy.has_passed()) << "a set was given while a frame still read it";
  ASSERT_TRUE(store.begin_picture());
  store.end_picture({});
  glFinish();
  EXPECT_EQ(shown_picture(store), 1U) << "an inner frame shows what the outer one does";
  store.release();
  EXPECT_EQ(shown_picture(store), 3U);
}

TEST_F(PublishingTest, ExtractionIsNeverSoFarAheadThatNoPictureIsEverShown) {
  const PolygonModel model = rows_of_quads({5});
  extraction();
  TextureStore store(model, tight_layout(model, kMixedSizes, 128), Publishing::buffered);
  const BusyWork work;
  GlFence busy;
  for (int k = 1; k <= 2; ++k) {
    ASSERT_TRUE(store.begin_picture());
    busy = work.issue();
    store.end_picture({});
  }
  EXPECT_FALSE(store.begin_picture());
  ASSERT_FALSE(busy.has_passed()) << "the work is too quick for this test, or begin_picture() waited for it";
  store.wait_for_free_set();
  EXPECT_TRUE(store.begin_picture());
  EXPECT_GE(shown_picture(store), 1U);
  extraction();
  store.end_picture({});
}

TEST_F(PublishingTest, AbandonedPictureIsNeverShownAndLeavesNothing) {
  const PolygonModel model = rows_of_quads({5});
  TextureStore direct(model, tight_layout(model, kMixedSizes, 128));
  TextureStore store(model, tight_layout(model, kMixedSizes, 128), Publishing::buffered);
  for (std::uint32_t k = 1; k <= 12; ++k) {
    const std::vector<std::uint32_t> touched{k % 5, (k + 1) % 5};
    const GLuint newest = store.pages();
    const std::uint64_t shown = shown_picture(store);
    extraction();
    ASSERT_TRUE(store.begin_picture_in_pieces());
    ASSERT_NE(store.pages(), newest);
    // Now and then before all was brought up to date.
    while (store.catch_up_left() > 0 && k % 3 != 0) store.catch_up(20'000);
    paint(store, all_polygons(store), colour_of(100 + k));
    store.abandon_picture();
    EXPECT_EQ(store.pages(), newest);
    glFinish();
    EXPECT_EQ(shown_picture(store), shown);
    extraction();
    for (TextureStore* s : {&direct, &store}) {
      ASSERT_TRUE(s->begin_picture());
      paint(*s, touched, colour_of(k));
      s->end_picture(touched);
    }
    glFinish();
    EXPECT_EQ(difference(store, store.pages(), store.polygon_states(), direct), "") << k;
    EXPECT_EQ(shown_picture(store), k);
  }
}

TEST_F(PublishingTest, PictureInSlicesPausesWhileTheDisplayReadsAllOtherSets) {
  const PolygonModel model = rows_of_quads({5});
  CameraFrame picture;
  picture.camera.width = picture.camera.height = 64;
  picture.camera.focal_length = {64, 64};
  picture.camera.principal_point = {32, 32};
  picture.picture = cv::Mat(64, 64, CV_8UC3, cv::Scalar(10, 100, 200));
  picture.state.world_from_part.resize(model.parts().size());
  picture.state.world_from_camera.translation.z = -1;
  const BusyWork work;
  for (const PipelineKind kind : {PipelineKind::batched, PipelineKind::per_polygon}) {
    extraction();
    TextureStore store(model, tight_layout(model, kMixedSizes, 128), Publishing::buffered);
    const auto pipeline = make_extraction_pipeline(kind, store, {}, {});
    pipeline->begin(picture);
    // As far as it goes without a set to write into.
    const std::size_t before_the_set = kind == PipelineKind::per_polygon ? 0 : kSlicesBeforeTheSet;
    for (std::size_t i = 0; i < before_the_set; ++i) {
      ASSERT_TRUE(pipeline->pending_slice());
      static_cast<void>(pipeline->run_slice(1e9));
      glFinish();
    }
    display();
    EXPECT_EQ(store.acquire().picture, 0U);
    publish_nothing(store);
    glFinish();
    display();
    const GlFence busy = work.issue();
    store.release();
    EXPECT_EQ(store.acquire().picture, 1U);
    publish_nothing(store);
    // One set has a frame in flight, one is held, one is the newest.
    EXPECT_FALSE(pipeline->pending_slice());
    EXPECT_TRUE(pipeline->is_busy());
    ASSERT_FALSE(busy.has_passed()) << "the work is too quick for this test, or pending_slice() waited for it";
    store.wait_for_free_set();
    extraction();
    while (pipeline->pending_slice()) {
      static_cast<void>(pipeline->run_slice(1e9));
      glFinish();
    }
    EXPECT_FALSE(pipeline->is_busy());
    EXPECT_EQ(store.pictures_ended(), 3U);
    display();
    store.release();
    EXPECT_EQ(shown_picture(store), 3U);
    extraction();
  }
  display();
}

TEST_F(PublishingTest, ClearingAndLoadingArePublishedAsAWholeToo) {
  const PolygonModel model = rows_of_quads({9});
  extraction();
  const ChartLayout layout = tight_layout(model, kMixedSizes, 128);
  TextureStore direct(model, layout), store(model, layout, Publishing::buffered);
  for (std::uint64_t k = 1; k <= 4; ++k) publish(store, colour_of(k));
  display();
  const TextureStore::Shown before = store.acquire();
  extraction();
  store.clear();
  glFinish();
  const Chart& chart = layout.charts[3];
  EXPECT_EQ(part_of(read_level(layout, before.pages, 0, chart.page), chart, 0).at<cv::Vec4b>(0, 0)[0], 4)
      << "cleared under the display's eyes";
  display();
  store.release();
  TextureStore::Shown shown = store.acquire();
  EXPECT_EQ(shown.picture, 4U);
  EXPECT_EQ(difference(store, shown.pages, shown.polygon_states, direct), "");
  store.release();

  extraction();
  std::vector<cv::Mat> pages;
  for (std::uint32_t page = 0; page < layout.pages; ++page) {
    pages.emplace_back(128, 128, CV_8UC4);
    cv::randu(pages.back(), 0, 256);
  }
  const std::vector<State> states(9, State{0.1F, 0.2F, 0.3F, 1.0F});
  direct.write_pages(pages, states);
  store.write_pages(pages, states);
  EXPECT_EQ(cv::norm(store.read_pages()[0], pages[0], cv::NORM_INF), 0);
  glFinish();
  display();
  shown = store.acquire();
  EXPECT_EQ(difference(store, shown.pages, shown.polygon_states, direct), "");
  store.release();
}

TEST_F(PublishingTest, FencesDoNotPileUp) {
  const PolygonModel model = rows_of_quads({5});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128), Publishing::buffered);
  const long before = live_gl_objects();
  publish(store, colour_of(1));
  EXPECT_GT(live_gl_objects(), before) << "fences are not counted";
  for (std::uint64_t k = 2; k < 50; ++k) {
    publish(store, colour_of(k));
    for (int frame = 0; frame < 5; ++frame) static_cast<void>(shown_picture(store));
    // At most one behind each set's picture, and one behind each set's last frame.
    ASSERT_LE(live_gl_objects(), before + 6);
  }
  for (int frame = 0; frame < 50; ++frame) static_cast<void>(shown_picture(store));
  EXPECT_LE(live_gl_objects(), before + 6);
}

TEST_F(PublishingTest, DirectStoreShowsWhatWasWrittenAtOnce) {
  const PolygonModel model = rows_of_quads({5});
  const ChartLayout layout = tight_layout(model, kMixedSizes, 128);
  TextureStore store(model, layout);
  const long before = live_gl_objects();
  store.wait_for_free_set();
  EXPECT_TRUE(store.begin_picture());
  const TextureStore::Shown shown = store.acquire();
  EXPECT_EQ(shown.pages, store.pages());
  EXPECT_EQ(shown.polygon_states, store.polygon_states());
  EXPECT_EQ(shown.picture, 0U);
  store.release();
  store.end_picture({});
  EXPECT_EQ(store.acquire().picture, 1U);
  store.release();
  EXPECT_EQ(live_gl_objects(), before);
  const TextureStore buffered(model, layout, Publishing::buffered);
  EXPECT_EQ(buffered.memory_bytes(), 3 * store.memory_bytes());
  EXPECT_GE(store.memory_bytes(), layout.memory_bytes);
}

/// The per-polygon pipeline, writing into three sets and into one.
class PublishedExtraction : public ExtractionTest, public ::testing::WithParamInterface<PageCopier::Method> {};

TEST_P(PublishedExtraction, GivesTheSameTexturesThroughThreeSets) {
  RawMesh mesh;
  add_quad(mesh, -0.5, -0.4, -0.1, 0.4, 1.0);
  add_quad(mesh, 0.0, -0.4, 0.5, 0.4, 1.2);
  add_quad(mesh, -0.2, -0.1, 0.2, 0.1, 0.8);
  build(mesh);
  TextureStore store(*model_, store_->layout(), Publishing::buffered);
  store.set_copy_method(GetParam());
  PerPolygonExtraction pipeline(store, charts_, options_);
  for (int k = 1; k <= 6; ++k) {
    CameraFrame picture = frame(k % 2 == 0 ? plain(20.0 * k) : gradient, k);
    // Now the one, now the other out of sight.
    picture.state.world_from_camera.translation.x = k % 3 - 1.0;
    pipeline_->extract(picture);
    pipeline.extract(picture);
    EXPECT_EQ(difference(store, store.pages(), store.polygon_states(), *store_), "") << k;
    glFinish();
    const TextureStore::Shown shown = store.acquire();
    EXPECT_EQ(shown.picture, static_cast<std::uint64_t>(k));
    EXPECT_EQ(difference(store, shown.pages, shown.polygon_states, *store_), "") << k;
    store.release();
  }
}

INSTANTIATE_TEST_SUITE_P(Publishing, PublishedExtraction,
                         ::testing::Values(PageCopier::Method::commands, PageCopier::Method::dispatch), name_of);

}  // namespace
}  // namespace foreview
