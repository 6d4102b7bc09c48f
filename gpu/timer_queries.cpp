#include "foreview/gpu/timer_queries.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace foreview {
namespace {

constexpr int kSide = 512;            ///< texels of the images that the work writes
constexpr double kLeastWork = 5;      ///< milliseconds
constexpr int kMostRounds = 1 << 22;  ///< of a GPU so fast that it needs more, timestamps are not asked
constexpr double kTolerance = 0.2;
constexpr int kTries = 3;

/// A float image as target of draws and dispatches, and the programs that keep it busy.
class KnownWork {
 public:
  KnownWork()
      : compute_(make_compute_program("timer_work.comp.glsl")),
        draw_(make_program("fullscreen.vert.glsl", "timer_work.frag.glsl")),
        no_vertices_(GlVertexArray::create()) {
    for (int i = 0; i < 2; ++i) {
      images_[i] = make_texture_2d(GL_R32F, kSide, kSide);
      framebuffers_[i] = make_framebuffer(images_[i].id());
    }
  }
  void dispatch(int rounds) const {
    glUseProgram(compute_.id());
    glUniform1i(0, rounds);
    glBindImageTexture(0, images_[0].id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glDispatchCompute(kSide / 8, kSide / 8, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
  }
  void draw(int rounds) const { draw_into(0, rounds); }
  /// Eight draws, each into another target than the one before.
  void passes(int rounds) const {
    for (int i = 0; i < 8; ++i) draw_into(i % 2, std::max(1, rounds / 8));
  }

 private:
  void draw_into(int target, int rounds) const {
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glViewport(0, 0, kSide, kSide);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[target].id());
    glUseProgram(draw_.id());
    glUniform1i(0, rounds);
    glBindVertexArray(no_vertices_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  }

  GlProgram compute_, draw_;
  GlVertexArray no_vertices_;
  GlTexture images_[2];
  GlFramebuffer framebuffers_[2];
};

template <typename Issue>
TimerCheck::Work time_once(const char* kind, TimerQueries& queries, int rounds, Issue&& issue) {
  glFinish();
  queries.restart();
  const auto start = std::chrono::steady_clock::now();
  queries.mark();
  issue(rounds);
  queries.mark();
  glFinish();
  const double wall = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  const std::vector<std::int64_t> times = queries.resolve();
  return {kind, wall, static_cast<double>(times[1] - times[0]) * 1e-6};
}

bool agree(const TimerCheck::Work& work) {
  return work.wall_ms > 0 && std::abs(work.query_ms - work.wall_ms) <= kTolerance * work.wall_ms;
}

/// As many rounds as take at least kLeastWork; then the shortest of a few tries: a wall clock is easily too late.
template <typename Issue>
TimerCheck::Work time_work(const char* kind, TimerQueries& queries, Issue&& issue) {
  int rounds = 8;
  TimerCheck::Work best = time_once(kind, queries, rounds, issue);
  while (best.wall_ms < kLeastWork && rounds < kMostRounds) {
    rounds *= 2;
    best = time_once(kind, queries, rounds, issue);
  }
  // The first runs of a program may have been longer by its compilation: what is asked is whether it now suffices.
  for (int i = 0; i < kTries; ++i) {
    const TimerCheck::Work again = time_once(kind, queries, rounds, issue);
    if (again.wall_ms < kLeastWork && rounds < kMostRounds) {
      rounds *= 2;
      --i;
      continue;
    }
    if (i == 0 || again.wall_ms < best.wall_ms) best = again;
  }
  return best;
}

}  // namespace

std::size_t TimerQueries::mark() {
  if (used_ == queries_.size()) queries_.push_back(GlTimestampQuery::create());
  glQueryCounter(queries_[used_].id(), GL_TIMESTAMP);
  return used_++;
}

std::vector<std::int64_t> TimerQueries::resolve() const {
  std::vector<std::int64_t> times(used_);
  for (std::size_t i = 0; i < used_; ++i) glGetQueryObjecti64v(queries_[i].id(), GL_QUERY_RESULT, &times[i]);
  return times;
}

TimerCheck check_timer_queries() {
  TimerCheck check;
  GLint bits = 0;
  glGetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
  if (bits == 0) return check;
  const KnownWork work;
  TimerQueries queries;
  check.works.push_back(time_work("dispatch", queries, [&](int rounds) { work.dispatch(rounds); }));
  check.works.push_back(time_work("draw", queries, [&](int rounds) { work.draw(rounds); }));
  check.works.push_back(time_work("passes", queries, [&](int rounds) { work.passes(rounds); }));
  check.truthful = std::ranges::all_of(check.works, agree);
  return check;
}

const TimerCheck& startup_timer_check() {
  static const TimerCheck check = check_timer_queries();
  return check;
}

bool timer_queries_are_truthful() {
  return startup_timer_check().truthful;
}

}  // namespace foreview
