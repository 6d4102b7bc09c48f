#include "foreview/gpu/texture_store.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <opencv2/core.hpp>
#include <optional>
#include <random>

#include "gpu/gl_test_fixture.h"
#include "gpu/test_model.h"

namespace foreview {
namespace {

using State = TextureStore::PolygonState;

const std::vector<glm::ivec2> kMixedSizes{{16, 16}, {32, 16}, {16, 48}, {64, 64}, {16, 16}};

/// Level `level` of all pages, BGRA.
std::vector<cv::Mat> read_level(const TextureStore& store, int level) {
  const int size = store.layout().page_size >> level;
  std::vector<cv::Mat> pages;
  for (std::uint32_t page = 0; page < store.layout().pages; ++page) {
    cv::Mat& picture = pages.emplace_back(size, size, CV_8UC4);
    glGetTextureSubImage(store.pages(), level, 0, 0, static_cast<GLint>(page), size, size, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                         size * size * 4, picture.data);
  }
  return pages;
}

cv::Rect rect_of(const Chart& chart, int level = 0) {
  return {chart.origin.x >> level, chart.origin.y >> level, chart.size.x >> level, chart.size.y >> level};
}

std::vector<cv::Mat> blank_pages(const ChartLayout& layout, const cv::Scalar& value = cv::Scalar::all(0)) {
  std::vector<cv::Mat> pages;
  for (std::uint32_t i = 0; i < layout.pages; ++i)
    pages.emplace_back(layout.page_size, layout.page_size, CV_8UC4, value);
  return pages;
}

std::vector<cv::Mat> random_pages(const ChartLayout& layout) {
  std::vector<cv::Mat> pages = blank_pages(layout);
  cv::RNG random(7);
  for (cv::Mat& page : pages) random.fill(page, cv::RNG::UNIFORM, 0, 256);
  return pages;
}

TEST_F(GlTest, StoreBeginsWithNothingSeen) {
  const PolygonModel model = rows_of_quads({5});
  const TextureStore store(model, tight_layout(model, kMixedSizes, 128));
  EXPECT_EQ(store.count_observed_texels(), 0U);
  for (int level = 0; level < kChartLevels; ++level) {
    for (const cv::Mat& page : read_level(store, level)) EXPECT_EQ(cv::countNonZero(page.reshape(1)), 0);
  }
  for (const State& state : store.read_polygon_states()) {
    EXPECT_EQ(state.seen, 0.0F);
    EXPECT_EQ(state.red, 0.5F);
  }
}

TEST_F(GlTest, StoreReadsBackWhatWasWrittenAndForgetsIt) {
  const PolygonModel model = rows_of_quads({9});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128));
  ASSERT_GT(store.layout().pages, 1U);
  const std::vector<cv::Mat> pages = random_pages(store.layout());
  std::vector<State> states;
  for (int i = 0; i < 9; ++i) {
    const auto value = static_cast<float>(i);
    states.push_back({0.1F * value, 0.2F, 0.01F * value, i % 2 == 0 ? 1.0F : 0.5F});
  }
  store.write_pages(pages, states);
  const std::vector<cv::Mat> read = store.read_pages();
  ASSERT_EQ(read.size(), pages.size());
  std::size_t observed = 0;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    EXPECT_EQ(cv::norm(read[i], pages[i], cv::NORM_INF), 0);
    cv::Mat alpha;
    cv::extractChannel(pages[i], alpha, 3);
    observed += static_cast<std::size_t>(cv::countNonZero(alpha == 255));
  }
  EXPECT_EQ(store.count_observed_texels(), observed);
  const std::vector<State> read_states = store.read_polygon_states();
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(read_states[i].red, states[i].red);
    EXPECT_EQ(read_states[i].green, states[i].green);
    EXPECT_EQ(read_states[i].blue, states[i].blue);
    EXPECT_EQ(read_states[i].seen, states[i].seen);
  }
  store.clear();
  EXPECT_EQ(store.count_observed_texels(), 0U);
  EXPECT_EQ(cv::countNonZero(read_level(store, 4)[0].reshape(1)), 0);
  EXPECT_EQ(store.read_polygon_states()[0].seen, 0.0F);
}

TEST_F(GlTest, StoreLevelsNeverMixChartsThatTouch) {
  const PolygonModel model = rows_of_quads({24});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128));
  // Extreme and all different, so that any foreign texel shows; around the charts a colour of its own.
  const auto colour_of = [](std::size_t i) {
    return cv::Vec4b(static_cast<uchar>(i % 2 * 255), static_cast<uchar>(i / 2 % 2 * 255),
                     static_cast<uchar>(i / 4 % 2 * 255), static_cast<uchar>(i / 8 % 2 * 255));
  };
  std::vector<cv::Mat> pages = blank_pages(store.layout(), cv::Scalar(90, 160, 30, 200));
  for (std::size_t i = 0; i < store.layout().charts.size(); ++i) {
    const Chart& chart = store.layout().charts[i];
    pages[chart.page](rect_of(chart)).setTo(cv::Scalar(colour_of(i)));
  }
  store.write_pages(pages, std::vector<State>(24));
  for (int level = 0; level < kChartLevels; ++level) {
    const std::vector<cv::Mat> read = read_level(store, level);
    for (std::size_t i = 0; i < store.layout().charts.size(); ++i) {
      const Chart& chart = store.layout().charts[i];
      const cv::Mat part = read[chart.page](rect_of(chart, level));
      EXPECT_EQ(cv::norm(part, cv::Mat(part.size(), CV_8UC4, cv::Scalar(colour_of(i))), cv::NORM_INF), 0)
          << "chart " << i << " level " << level;
    }
  }
}

TEST_F(GlTest, StoreLevelsAreMeansOfAllTexelsBelowColourAndAlpha) {
  const PolygonModel model = rows_of_quads({9});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128));
  const std::vector<cv::Mat> pages = random_pages(store.layout());
  store.write_pages(pages, std::vector<State>(9));
  for (int level = 1; level < kChartLevels; ++level) {
    const std::vector<cv::Mat> read = read_level(store, level);
    const int block = 1 << level;
    for (const Chart& chart : store.layout().charts) {
      const cv::Rect rect = rect_of(chart, level);
      for (int y = rect.y; y < rect.br().y; ++y) {
        for (int x = rect.x; x < rect.br().x; ++x) {
          const cv::Scalar mean = cv::mean(pages[chart.page](cv::Rect(x * block, y * block, block, block)));
          const cv::Vec4b got = read[chart.page].at<cv::Vec4b>(y, x);
          for (int c = 0; c < 4; ++c) ASSERT_NEAR(got[c], mean[c], 0.51) << level << " " << x << " " << y << " " << c;
        }
      }
    }
  }
}

TEST_F(GlTest, StoreUpdatesLevelsOfTheNamedChartsOnly) {
  const PolygonModel model = rows_of_quads({9});
  TextureStore store(model, tight_layout(model, kMixedSizes, 128));
  store.write_pages(blank_pages(store.layout(), cv::Scalar(10, 20, 30, 0)), std::vector<State>(9));
  const std::vector<cv::Mat> pages = blank_pages(store.layout(), cv::Scalar(200, 210, 220, 255));
  for (std::uint32_t page = 0; page < store.layout().pages; ++page) {
    glTextureSubImage3D(store.pages(), 0, 0, 0, static_cast<GLint>(page), 128, 128, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                        pages[page].data);
  }
  store.update_levels({});
  store.update_levels({3, 7});
  for (int level = 1; level < kChartLevels; ++level) {
    const std::vector<cv::Mat> read = read_level(store, level);
    for (std::size_t i = 0; i < 9; ++i) {
      const Chart& chart = store.layout().charts[i];
      const cv::Mat part = read[chart.page](rect_of(chart, level));
      const cv::Scalar expected = i == 3 || i == 7 ? cv::Scalar(200, 210, 220, 255) : cv::Scalar(10, 20, 30, 0);
      EXPECT_EQ(cv::norm(part, cv::Mat(part.size(), CV_8UC4, expected), cv::NORM_INF), 0) << i << " level " << level;
    }
  }
}

TEST_F(GlTest, StoreUpdatesAGroupOnceHoweverManyOfItAreNamed) {
  const PolygonModel model = rows_of_quads({5, 4});
  ChartOptions options;
  options.texels_per_metre = 200;
  options.page_size = 256;
  const ChartLayout layout = lay_out_charts(model, options);
  ASSERT_EQ(layout.groups.size(), 2U);
  TextureStore store(model, layout);
  const std::vector<cv::Mat> pages = random_pages(layout);
  store.write_pages(pages, std::vector<State>(9));
  std::vector<std::vector<cv::Mat>> whole;
  for (int level = 1; level < kChartLevels; ++level) whole.push_back(read_level(store, level));
  // The list of blocks has room for each block once: naming it twice would be an error of OpenGL.
  store.write_pages(blank_pages(layout), std::vector<State>(9));
  glTextureSubImage3D(store.pages(), 0, 0, 0, 0, layout.page_size, layout.page_size, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                      pages[0].data);
  store.update_levels({3, 0, 2});
  const Chart& updated = layout.charts[0];
  const Chart& other = layout.charts[8];
  for (int level = 1; level < kChartLevels; ++level) {
    const cv::Mat read = read_level(store, level)[0];
    EXPECT_EQ(cv::norm(read(rect_of(updated, level)),
                       whole[static_cast<std::size_t>(level - 1)][0](rect_of(updated, level)), cv::NORM_INF),
              0)
        << level;
    EXPECT_EQ(cv::norm(read(rect_of(other, level)), cv::NORM_INF), 0) << level;
  }
}

TEST_F(GlTest, StoreRefusesWhatTheDriverCannotHold) {
  const PolygonModel model = rows_of_quads({2});
  GLint max_size = 0, max_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &max_layers);
  ChartLayout wide = tight_layout(model, {{16, 16}}, 128);
  wide.page_size = 2 * max_size;
  try {
    const TextureStore store(model, wide);
    FAIL() << "accepted a page of " << wide.page_size;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("larger than this graphics driver's limit"), std::string::npos)
        << error.what();
  }
  ChartLayout deep = tight_layout(model, {{16, 16}}, 128);
  deep.pages = static_cast<std::uint32_t>(max_layers) + 1;
  EXPECT_THROW(const TextureStore store(model, deep), InputError);
}

class Spread : public GlTest {
 protected:
  /// `seen`: polygon and its grey value; the others get a wrong colour that must not survive.
  static std::vector<State> spread(const std::vector<int>& rows, const std::vector<std::pair<std::size_t, float>>& seen,
                                   float stale = 0.0F, std::optional<unsigned> max_rims = std::nullopt) {
    const PolygonModel model = rows_of_quads(rows);
    TextureStore store(model, tight_layout(model, {{16, 16}}, 512));
    std::vector<State> states(model.polygons().size(), State{0.9F, 0.1F, 0.9F, stale});
    for (const auto& [polygon, grey] : seen) states[polygon] = {grey, grey / 2, grey / 4, 1.0F};
    store.write_pages(blank_pages(store.layout()), states);
    if (max_rims) {
      store.spread_to_never_seen(*max_rims);
    } else {
      store.spread_to_never_seen();
    }
    return store.read_polygon_states();
  }
};

TEST_F(Spread, GoesFromRimToRimAndAveragesWhereFrontsMeet) {
  const std::vector<State> states = spread({7}, {{0, 0.2F}, {6, 0.8F}});
  const std::vector<float> expected{0.2F, 0.2F, 0.2F, 0.5F, 0.8F, 0.8F, 0.8F};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(states[i].red, expected[i], 1e-6) << i;
    EXPECT_NEAR(states[i].green, expected[i] / 2, 1e-6) << i;
    EXPECT_NEAR(states[i].blue, expected[i] / 4, 1e-6) << i;
    EXPECT_EQ(states[i].seen, i == 0 || i == 6 ? 1.0F : 0.5F) << i;
  }
}

TEST_F(Spread, ReachesTheEndOfALongChain) {
  for (const int length : {16, 17, 18, 200}) {
    const std::vector<State> states = spread({length}, {{0, 0.25F}});
    EXPECT_EQ(states.back().red, 0.25F) << length;
    EXPECT_EQ(states.back().seen, 0.5F) << length;
  }
}

TEST_F(Spread, FrontsMeetHalfwayThoughWorkgroupsRunInAnyOrder) {
  const std::vector<State> states = spread({200}, {{0, 0.25F}, {199, 0.75F}});
  for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(states[i].red, i < 100 ? 0.25F : 0.75F) << i;
}

TEST_F(Spread, GivesIslandsTheMeanOfAllSeen) {
  const std::vector<State> states = spread({3, 3}, {{0, 0.2F}, {2, 0.4F}});
  for (std::size_t i = 3; i < 6; ++i) {
    EXPECT_NEAR(states[i].red, 0.3F, 1e-6);
    EXPECT_NEAR(states[i].blue, 0.075F, 1e-6);
    EXPECT_EQ(states[i].seen, 0.5F);
  }
}

TEST_F(Spread, GoesNoDeeperThanAskedAndGivesTheRestTheMean) {
  for (const unsigned rims : {0U, 1U, 5U, 16U, 17U, 40U}) {
    const std::vector<State> states = spread({100}, {{0, 0.25F}, {99, 0.75F}}, 0.5F, rims);
    for (std::size_t i = 0; i < 100; ++i) {
      const float expected = i <= rims ? 0.25F : i >= 99 - rims ? 0.75F : 0.5F;
      ASSERT_EQ(states[i].red, expected) << i << " with " << rims;
      ASSERT_EQ(states[i].seen, i == 0 || i == 99 ? 1.0F : 0.5F) << i << " with " << rims;
    }
  }
}

TEST_F(Spread, IsTheSameAsTheWaitingFormWhereItReachesAll) {
  const std::vector<std::pair<std::size_t, float>> seen{{3, 0.1F}, {17, 0.9F}, {40, 0.3F}, {41, 0.6F}};
  const std::vector<State> exact = spread({30, 20, 4}, seen), bounded = spread({30, 20, 4}, seen, 0.5F, 16);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_EQ(bounded[i].red, exact[i].red) << i;
    EXPECT_EQ(bounded[i].seen, exact[i].seen) << i;
  }
}

TEST_F(Spread, IsMidGreyWhereNothingWasSeen) {
  for (const float stale : {0.0F, 0.5F}) {
    for (const State& state : spread({3, 1}, {}, stale)) {
      EXPECT_EQ(state.red, 0.5F);
      EXPECT_EQ(state.green, 0.5F);
      EXPECT_EQ(state.seen, 0.0F);
    }
  }
}

TEST_F(Spread, ForgetsWhatAnEarlierSpreadWrote) {
  const std::vector<State> states = spread({4}, {{3, 0.6F}}, 0.5F);
  for (const State& state : states) EXPECT_NEAR(state.red, 0.6F, 1e-6);
}

TEST_F(Spread, LeavesAllSeenAlone) {
  const std::vector<State> states = spread({2}, {{0, 0.6F}, {1, 0.1F}});
  EXPECT_EQ(states[0].red, 0.6F);
  EXPECT_EQ(states[1].red, 0.1F);
}

}  // namespace
}  // namespace foreview
