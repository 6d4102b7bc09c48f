#include "foreview/gpu/timer_queries.h"

#include <numeric>
#include <string>
#include <vector>

#include "foreview/gpu/step_clock.h"
#include "gpu/gl_test_fixture.h"

namespace foreview {
namespace {

class TimerQueriesTest : public GlTest {
 protected:
  static bool is_software() {
    const std::string renderer = context().renderer();
    return renderer.find("llvmpipe") != std::string::npos || renderer.find("softpipe") != std::string::npos;
  }
  /// Something for the GPU to do.
  void work() const {
    const float colour[4] = {0.25F, 0.5F, 0.75F, 1};
    glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, colour);
  }

 private:
  GlTexture image_ = make_texture_2d(GL_RGBA8, 256, 256);
  GlFramebuffer framebuffer_ = make_framebuffer(image_.id());
};

TEST_F(TimerQueriesTest, TheCheckTimesEnoughWorkOfEveryKind) {
  const TimerCheck check = check_timer_queries();
  ASSERT_EQ(check.works.size(), 3U);
  bool all_agree = true;
  for (const TimerCheck::Work& work : check.works) {
    RecordProperty(std::string(work.kind) + "_wall_ms", std::to_string(work.wall_ms));
    RecordProperty(std::string(work.kind) + "_query_ms", std::to_string(work.query_ms));
    EXPECT_GE(work.wall_ms, 5) << work.kind;
    all_agree = all_agree && work.query_ms > 0.8 * work.wall_ms && work.query_ms < 1.2 * work.wall_ms;
  }
  EXPECT_EQ(check.truthful, all_agree);
}

TEST_F(TimerQueriesTest, SoftwareRasterisersAreFoundOut) {
  if (!is_software()) GTEST_SKIP() << "not a software rasteriser: " << context().renderer();
  EXPECT_FALSE(check_timer_queries().truthful);
  EXPECT_FALSE(timer_queries_are_truthful());
}

TEST_F(TimerQueriesTest, MarksComeInOrderFromQueriesThatAreUsedAgain) {
  TimerQueries queries;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(queries.mark(), static_cast<std::size_t>(i));
  const long live = live_gl_objects();
  for (int picture = 0; picture < 3; ++picture) {
    queries.restart();
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(queries.mark(), static_cast<std::size_t>(i));
      work();
    }
    const std::vector<std::int64_t> times = queries.resolve();
    ASSERT_EQ(times.size(), 5U);
    for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GE(times[i], times[i - 1]);
  }
  EXPECT_EQ(live_gl_objects(), live);
}

TEST_F(TimerQueriesTest, AClockSwitchedOffReportsNothing) {
  StepClock clock(ExtractionTiming::off);
  clock.lap(ExtractionStep::upload);
  ExtractionStatistics statistics;
  clock.report(statistics);
  EXPECT_TRUE(statistics.spans.empty());
  EXPECT_EQ(statistics.total_ms, 0);
}

TEST_F(TimerQueriesTest, StepsAddUpToTheTotalWithEitherMethod) {
  TimerQueries queries;
  for (const ExtractionTiming timing : {ExtractionTiming::finish, ExtractionTiming::queries}) {
    StepClock clock(timing, &queries);
    const std::vector<ExtractionStep> steps{ExtractionStep::upload, ExtractionStep::filling, ExtractionStep::upload};
    for (const ExtractionStep step : steps) {
      work();
      clock.lap(step);
    }
    ExtractionStatistics statistics;
    clock.report(statistics);
    ASSERT_EQ(statistics.spans.size(), steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const StepSpan& span = statistics.spans[i];
      EXPECT_EQ(span.step, steps[i]);
      EXPECT_LE(span.cpu_begin, span.cpu_end);
      EXPECT_LE(span.gpu_begin, span.gpu_end);
      if (i > 0) {
        EXPECT_GE(span.cpu_begin, statistics.spans[i - 1].cpu_end);
        EXPECT_EQ(span.gpu_begin, statistics.spans[i - 1].gpu_end);
      }
    }
    const double sum = std::accumulate(statistics.step_ms.begin(), statistics.step_ms.end(), 0.0);
    EXPECT_NEAR(sum, statistics.total_ms, 1e-9 + 1e-9 * statistics.total_ms);
    EXPECT_EQ(statistics.ms(ExtractionStep::suppression), 0);
    if (timing == ExtractionTiming::finish) {
      EXPECT_GT(statistics.ms(ExtractionStep::upload), 0);
    }
  }
}

}  // namespace
}  // namespace foreview
