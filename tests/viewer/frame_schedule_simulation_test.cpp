#include "foreview/viewer/frame_schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <sstream>
#include <string>

namespace foreview {
namespace {

using Action = FrameSchedule::Action;
using Slice = FrameSchedule::Slice;

constexpr Duration us(std::int64_t microseconds) {
  return {microseconds * 1000};
}
constexpr Duration ms(std::int64_t milliseconds) {
  return us(milliseconds * 1000);
}
constexpr Timestamp at(std::int64_t milliseconds) {
  return {milliseconds * 1'000'000};
}

/// A drawn world in which the schedule is driven as the header says, and everything it does is checked from outside:
/// against the event log, not against the schedule's own books.
struct World {
  FrameSchedule::Options options;
  Duration frame_least, frame_greatest;          // a frame's cost, evenly spread
  double slice_least = 0.5, slice_greatest = 1;  // a slice's cost per declared bound, evenly spread
  double outliers = 0;                           // part of the frames and slices that cost 5 to 30 ms more
  Duration oversleeping;                         // at most
  Duration between_pictures;                     // 0: always another one
  int greatest_slice_count = 20;
  Duration run_time = ms(2000);
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double least, double greatest) {
    return least + (greatest - least) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// Whole microseconds.
  Duration between(Duration least, Duration greatest) {
    return us(std::llround(between(static_cast<double>(least.nanoseconds), static_cast<double>(greatest.nanoseconds)) /
                           1000));
  }
  bool chance(double p) { return between(0, 1) < p; }

 private:
  std::mt19937_64 engine_;
};

/// What the log of a run amounts to, counted independently.
struct Outcome {
  std::int64_t frames = 0, late = 0, skipped = 0, missed = 0, slices = 0, oversize = 0;
  std::int64_t frames_with_work_throughout = 0;
  Duration extraction, worst_lateness;
  std::string log;
};

Duration positive(Duration d) {
  return std::max(d, Duration{});
}

class Simulation {
 public:
  Simulation(World world, std::uint64_t seed)
      : world_(std::move(world)), random_(seed), schedule_(world_.options, at(0)) {}

  Outcome run() {
    arrival_ = at(0) + random_.between(us(0), world_.between_pictures);
    while (now_ < at(0) + world_.run_time && !testing::Test::HasFailure()) {
      step();
    }
    check_statistics();
    return outcome_;
  }
  [[nodiscard]] const FrameSchedule& schedule() const { return schedule_; }

 private:
  void receive_pictures() {
    while (arrival_ <= now_) {
      const auto count = static_cast<int>(random_.between(1, world_.greatest_slice_count + 0.999));
      if (pending_.empty()) {  // else the picture is overwritten
        for (int i = 0; i < count; ++i) {
          const double kind = random_.between(0, static_cast<double>(world_.options.slices.size()));
          pending_.push_back({static_cast<std::size_t>(kind), random_.between(0.2, 2)});
        }
      }
      if (world_.between_pictures == Duration{}) {
        break;
      }
      arrival_ = arrival_ + us(1) + random_.between(us(0), {2 * world_.between_pictures.nanoseconds});
    }
  }

  void step() {
    receive_pictures();
    const std::optional<Slice> slice = pending_.empty() ? std::nullopt : std::optional(pending_.front());
    const auto before = schedule_.statistics();
    const Duration cost = slice ? schedule_.cost(*slice) : Duration{};
    const auto decision = schedule_.next(now_, slice);
    const auto& after = schedule_.statistics();
    work_throughout_ = work_throughout_ && slice;
    outcome_.missed += after.missed - before.missed;
    missed_in_gap_ += after.missed - before.missed;
    if (after.oversize_slices != before.oversize_slices) {
      ++outcome_.oversize;
      oversize_in_gap_ = true;
    }
    switch (decision.action) {
      case Action::draw_frame:
        ASSERT_FALSE(decision.skipped_frame);
        check_grant(slice, cost);
        frame(decision.until);
        break;
      case Action::run_slice:
        ASSERT_TRUE(slice);
        ASSERT_EQ(decision.until, now_ + cost);
        admit(decision.skipped_frame, cost);
        run_slice(*slice, cost);
        break;
      case Action::wait_until:
        ASSERT_GT(decision.until, now_);
        ASSERT_EQ(decision.until, schedule_.frame_start());
        // Nothing waits that would fit.
        ASSERT_TRUE(!slice || now_ + cost > decision.until) << "at " << now_.to_string();
        wait(decision.until, !slice);
        break;
    }
  }

  void admit(bool skipped_frame, Duration cost) {
    if (skipped_frame) {
      // Only if extraction got next to nothing although it always had work, and once between two frames.
      ASSERT_EQ(skips_in_gap_, 0) << "two frames skipped in a row";
      ASSERT_TRUE(work_throughout_);
      ASSERT_LT(extraction_in_gap_, world_.options.t_diff);
      ++outcome_.skipped;
      ++skips_in_gap_;
      grant_end_ = now_ + std::min(world_.options.t_min, world_.options.period);
      outcome_.log += "skip ";
    } else {
      // It fits in before the frame, or into what extraction was granted.
      ASSERT_LE(now_ + cost, std::max(schedule_.frame_start(), skips_in_gap_ > 0 ? grant_end_ : now_));
    }
  }

  /// After a skip, extraction keeps the GPU as long as its slices fit into the time it was granted.
  void check_grant(const std::optional<Slice>& slice, Duration cost) {
    if (skips_in_gap_ > 0 && slice) {
      ASSERT_GT(now_ + cost, grant_end_) << "a frame took extraction's granted time";
    }
  }

  void run_slice(const Slice& slice, Duration reckoned) {
    const auto& bound = world_.options.slices[slice.kind];
    const double declared =
        static_cast<double>(bound.constant.nanoseconds) + slice.size * static_cast<double>(bound.per_unit.nanoseconds);
    Duration took =
        us(static_cast<std::int64_t>(declared * random_.between(world_.slice_least, world_.slice_greatest) / 1000));
    if (random_.chance(world_.outliers)) {
      took = took + random_.between(ms(5), ms(30));
    }
    schedule_.slice_started(slice, now_);
    now_ = now_ + took;
    schedule_.slice_completed(now_);
    pending_.erase(pending_.begin());
    last_slice_excess_ = positive({took.nanoseconds - reckoned.nanoseconds});
    excess_in_gap_ = excess_in_gap_ || last_slice_excess_ > Duration{};
    ++slices_in_gap_;
    ++outcome_.slices;
    overruns_ += took > reckoned ? 1 : 0;
    extraction_in_gap_ = extraction_in_gap_ + took;
    outcome_.extraction = outcome_.extraction + took;
    note("slice");
  }

  void wait(Timestamp until, bool for_work) {
    if (for_work && arrival_ < until) {
      now_ = arrival_;
      return;
    }
    const Duration overslept = random_.between(us(0), world_.oversleeping);
    now_ = until + overslept;
    last_oversleeping_ = overslept;
    excess_in_gap_ = excess_in_gap_ || overslept > Duration{};
  }

  void frame(Timestamp deadline) {
    const Duration reckoned = schedule_.frame_cost();
    Duration took = random_.between(world_.frame_least, world_.frame_greatest);
    if (random_.chance(world_.outliers)) {
      took = took + random_.between(ms(5), ms(30));
    }
    check_between_frames();
    // No earlier than it must: it is to show the newest input.
    ASSERT_GE(now_, deadline - reckoned - world_.options.margin);
    ASSERT_EQ((deadline - at(0)).nanoseconds % world_.options.period.nanoseconds, 0) << "off the grid";
    ASSERT_GT(deadline, last_deadline_);
    const auto before = schedule_.statistics().missed;
    const auto number = schedule_.frame_started(now_);
    missed_in_gap_ += schedule_.statistics().missed - before;
    outcome_.missed += schedule_.statistics().missed - before;
    check_missed();
    now_ = now_ + took;
    schedule_.frame_handed_over(now_);
    schedule_.frame_completed(number, now_);

    // The heart of it: a frame is late by no more than what its predecessor left behind, what the *one* slice before it
    // and what it took itself beyond what was reckoned (and, here, the driver's sleep); less the margin.
    const Duration lateness = now_ - deadline;
    const Duration excess = positive({took.nanoseconds - reckoned.nanoseconds});
    frame_overruns_ += excess > Duration{} ? 1 : 0;
    const Duration excused = inherited_ + last_slice_excess_ + last_oversleeping_ + excess;
    ASSERT_LE(lateness.nanoseconds, excused.nanoseconds - world_.options.margin.nanoseconds)
        << "late without a reason at " << now_.to_string();
    if (lateness > Duration{}) {
      ++outcome_.late;
      outcome_.worst_lateness = std::max(outcome_.worst_lateness, lateness);
    }
    inherited_ = positive(lateness);
    ++outcome_.frames;
    last_deadline_ = deadline;
    note("frame");
    work_throughout_ = true;
    extraction_in_gap_ = last_slice_excess_ = last_oversleeping_ = {};
    slices_in_gap_ = skips_in_gap_ = 0;
    missed_in_gap_ = 0;
    excess_in_gap_ = oversize_in_gap_ = false;
  }

  /// Extraction never starves, at any load: with work throughout, at least t_diff or a skip, and a slice at least.
  void check_between_frames() {
    if (outcome_.frames == 0 || !work_throughout_) {
      starved_gaps_ = 0;
      return;
    }
    ++outcome_.frames_with_work_throughout;
    const bool starved = extraction_in_gap_ < world_.options.t_diff && skips_in_gap_ == 0;
    starved_gaps_ = starved ? starved_gaps_ + 1 : 0;
    ASSERT_LT(starved_gaps_, world_.options.patience) << "extraction starved before " << now_.to_string();
    if (!starved) {
      ASSERT_GE(slices_in_gap_, 1);
    }
  }

  void check_missed() {
    if (missed_in_gap_ > schedule_.submultiple() - 1) {
      ASSERT_TRUE(inherited_ > Duration{} || excess_in_gap_ || oversize_in_gap_)
          << "missed without a reason before " << now_.to_string();
    }
  }

  void check_statistics() {
    const auto& statistics = schedule_.statistics();
    EXPECT_EQ(statistics.frames, outcome_.frames);
    EXPECT_EQ(statistics.late, outcome_.late);
    EXPECT_EQ(statistics.skipped, outcome_.skipped);
    EXPECT_EQ(statistics.missed, outcome_.missed);
    EXPECT_EQ(statistics.due, outcome_.frames + outcome_.skipped + outcome_.missed);
    EXPECT_EQ(statistics.slices, outcome_.slices);
    EXPECT_EQ(statistics.slice_overruns, overruns_);
    EXPECT_EQ(statistics.frame_overruns, frame_overruns_);
    EXPECT_EQ(statistics.extraction, outcome_.extraction);
    EXPECT_EQ(statistics.worst_lateness, outcome_.worst_lateness);
    EXPECT_EQ(statistics.stops, 0);
    // Every deadline up to the last one served or skipped is accounted for.
    if (skips_in_gap_ == 0) {
      EXPECT_EQ(statistics.due, (last_deadline_ - first_deadline_).nanoseconds / world_.options.period.nanoseconds + 1);
    }
  }

  void note(const char* what) {
    std::ostringstream line;
    line << what << ' ' << now_.nanoseconds << '\n';
    outcome_.log += line.str();
  }

  World world_;
  Random random_;
  FrameSchedule schedule_;
  Timestamp now_ = at(0), arrival_;
  std::vector<Slice> pending_;
  Outcome outcome_;
  // Since the last frame:
  bool work_throughout_ = false, excess_in_gap_ = false, oversize_in_gap_ = false;
  std::int64_t slices_in_gap_ = 0, skips_in_gap_ = 0, missed_in_gap_ = 0;
  Duration extraction_in_gap_, last_slice_excess_, last_oversleeping_;
  Timestamp grant_end_;
  Duration inherited_;  // lateness of the last frame
  Timestamp last_deadline_ = at(0);
  const Timestamp first_deadline_ = schedule_.deadline();
  std::int64_t overruns_ = 0, frame_overruns_ = 0;
  int starved_gaps_ = 0;  // in a row
};

constexpr std::uint64_t kSeeds = 300;

/// Everything at random; costs keep to what is declared.
World world_within_bounds(std::uint64_t seed) {
  Random random(seed * 1000 + 7);
  World world;
  world.options.period = random.between(ms(10), ms(40));
  const double period = static_cast<double>(world.options.period.nanoseconds);
  // From a light load to frames that cost more than the period.
  const double load =
      random.chance(0.6) ? random.between(0.05, 0.9) : random.between(0.9, random.chance(0.5) ? 1 : 1.8);
  world.options.frame = us(static_cast<std::int64_t>(load * period / 1000));
  world.frame_greatest = world.options.frame;
  world.frame_least = us(static_cast<std::int64_t>(load * period * random.between(0.2, 0.9) / 1000));
  const int kinds = 1 + static_cast<int>(random.between(0, 4));
  for (int i = 0; i < kinds; ++i) {
    const bool tiny = random.chance(0.2), oversize = random.chance(0.1);
    world.options.slices.push_back(
        {random.between(us(1), tiny ? us(10) : us(300)), random.between(us(10), tiny       ? us(20)
                                                                                : oversize ? ms(30)
                                                                                           : ms(3))});
  }
  world.options.margin = random.between(us(0), us(1000));
  world.options.patience = seed % 3 == 0 ? static_cast<int>(random.between(2, 5)) : 1;
  world.slice_least = random.between(0.1, 0.9);
  world.between_pictures = random.chance(0.3) ? Duration{} : random.between(ms(2), ms(150));
  world.greatest_slice_count = static_cast<int>(random.between(1, 40));
  return world;
}

/// The same, but what is declared is wrong by a factor, the machine hiccups and sleep is too long.
World wild_world(std::uint64_t seed) {
  World world = world_within_bounds(seed);
  Random random(seed * 1000 + 8);
  const double frames = random.between(0.3, 3);
  world.frame_greatest =
      us(static_cast<std::int64_t>(frames * static_cast<double>(world.frame_greatest.nanoseconds) / 1000));
  world.frame_least = us(world.frame_greatest.nanoseconds / 3000);
  world.slice_greatest = random.between(0.2, 4);
  world.slice_least = world.slice_greatest * random.between(0.3, 1);
  world.outliers = random.chance(0.5) ? random.between(0, 0.1) : 0;
  world.oversleeping = random.chance(0.5) ? random.between(us(0), us(3000)) : Duration{};
  return world;
}

TEST(FrameScheduleProperties, DeclaredBoundsThatHoldLeaveNoFrameLate) {
  std::int64_t frames = 0, skipped = 0, oversize = 0, slices = 0, missed_at_full_rate = 0, throughout = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    World world = world_within_bounds(seed);
    world.options.cost.floor = 1;
    Simulation simulation(world, seed);
    const Outcome outcome = simulation.run();
    ASSERT_EQ(outcome.late, 0);
    ASSERT_EQ(simulation.schedule().statistics().slice_overruns, 0);
    ASSERT_EQ(simulation.schedule().statistics().frame_overruns, 0);
    if (simulation.schedule().submultiple() == 1 && outcome.oversize == 0) {
      ASSERT_EQ(outcome.missed, 0);
      ++missed_at_full_rate;
    }
    frames += outcome.frames;
    skipped += outcome.skipped;
    oversize += outcome.oversize;
    slices += outcome.slices;
    throughout += outcome.frames_with_work_throughout;
  }
  // The worlds hold what they are meant to hold.
  EXPECT_GT(frames, 10'000);
  EXPECT_GT(slices, 10'000);
  EXPECT_GT(skipped, 1'000);
  EXPECT_GT(oversize, 100);
  EXPECT_GT(throughout, 3'000);
  EXPECT_GT(missed_at_full_rate, 100);
}

TEST(FrameScheduleProperties, LearntBoundsLeaveNoFrameLateWithoutAnOverrun) {
  std::int64_t late = 0, frames = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Simulation simulation(world_within_bounds(seed), seed);
    const Outcome outcome = simulation.run();
    ASSERT_FALSE(HasFailure());
    late += outcome.late;
    frames += outcome.frames;
  }
  // What was learnt is the second largest of 32: a few in a hundred exceed it, most of those within the margin.
  EXPECT_GT(late, 0);
  EXPECT_LT(static_cast<double>(late), 0.06 * static_cast<double>(frames));
}

TEST(FrameScheduleProperties, HoldWhenEveryBoundIsWrong) {
  std::int64_t late = 0, missed = 0, overruns = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Simulation simulation(wild_world(seed), seed);
    const Outcome outcome = simulation.run();
    ASSERT_FALSE(HasFailure());
    late += outcome.late;
    missed += outcome.missed;
    overruns += simulation.schedule().statistics().slice_overruns;
  }
  EXPECT_GT(late, 1'000);
  EXPECT_GT(missed, 1'000);
  EXPECT_GT(overruns, 1'000);
}

TEST(FrameScheduleProperties, EqualInputGivesEqualDecisions) {
  std::set<std::string> logs;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::string log = Simulation(wild_world(seed), seed).run().log;
    EXPECT_EQ(log, Simulation(wild_world(seed), seed).run().log);
    logs.insert(log);
  }
  EXPECT_EQ(logs.size(), 20U);
}

}  // namespace
}  // namespace foreview
