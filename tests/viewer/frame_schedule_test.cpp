#include "foreview/viewer/frame_schedule.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

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
constexpr Timestamp at_us(std::int64_t microseconds) {
  return {microseconds * 1000};
}
constexpr Timestamp at(std::int64_t milliseconds) {
  return at_us(milliseconds * 1000);
}

/// Drives a schedule by hand.
struct Desk {
  explicit Desk(const FrameSchedule::Options& options, Timestamp start = at(0))
      : schedule(options, start), now(start) {}

  FrameSchedule::Decision ask(const std::optional<Slice>& slice = std::nullopt) { return schedule.next(now, slice); }
  /// Waits for the next frame's start, draws it and returns its deadline. `waiting`: a slice that does not fit in.
  Timestamp draw(Duration cost, const std::optional<Slice>& waiting = std::nullopt) {
    auto decision = ask(waiting);
    if (decision.action == Action::wait_until) {
      now = decision.until;
      decision = ask(waiting);
    }
    EXPECT_EQ(decision.action, Action::draw_frame);
    const auto frame = schedule.frame_started(now);
    now = now + cost;
    schedule.frame_handed_over(now);
    schedule.frame_completed(frame, now);
    return decision.until;
  }
  void slice(const Slice& slice, Duration cost) {
    schedule.slice_started(slice, now);
    now = now + cost;
    schedule.slice_completed(now);
  }

  FrameSchedule schedule;
  Timestamp now;
};

/// 20 ms periods, frames of 5 ms, so that frames start 5.5 ms before their deadlines.
/// Kinds: 0: size in milliseconds; 1: 100 us and 2 ms per unit.
FrameSchedule::Options desk_options() {
  FrameSchedule::Options options;
  options.period = ms(20);
  options.frame = ms(5);
  options.slices = {{us(0), ms(1)}, {us(100), ms(2)}};
  return options;
}

TEST(FrameSchedule, SlicesRunUntilTheNextWouldNotFitInBeforeTheFrame) {
  Desk desk(desk_options());
  const Slice slice{0, 4};
  for (int i = 0; i < 3; ++i) {
    const auto decision = desk.ask(slice);
    ASSERT_EQ(decision.action, Action::run_slice);
    EXPECT_EQ(decision.until, desk.now + ms(4));
    EXPECT_FALSE(decision.skipped_frame);
    desk.slice(slice, ms(4));
  }
  ASSERT_EQ(desk.now, at(12));
  auto decision = desk.ask(slice);
  EXPECT_EQ(decision.action, Action::wait_until);
  EXPECT_EQ(decision.until, at_us(14'500));
  EXPECT_EQ(desk.ask(Slice{0, 2.5}).action, Action::run_slice) << "a smaller one fits exactly";
  desk.now = at_us(14'499);
  EXPECT_EQ(desk.ask(slice).action, Action::wait_until);
  desk.now = at_us(14'500);
  decision = desk.ask(slice);
  EXPECT_EQ(decision.action, Action::draw_frame);
  EXPECT_EQ(decision.until, at(20));
}

TEST(FrameSchedule, WithNothingToExtractFramesStartAsLateAsTheyCan) {
  Desk desk(desk_options());
  for (int i = 1; i <= 100; ++i) {
    const auto decision = desk.ask();
    ASSERT_EQ(decision.action, Action::wait_until);
    EXPECT_EQ(decision.until, at_us(i * 20'000 - 5'500));
    EXPECT_EQ(desk.draw(ms(5)), at(i * 20));
  }
  const auto& statistics = desk.schedule.statistics();
  EXPECT_EQ(statistics.due, 100);
  EXPECT_EQ(statistics.frames, 100);
  EXPECT_EQ(statistics.late + statistics.skipped + statistics.missed + statistics.slices, 0);
}

struct OverloadCase {
  const char* name;
  double slice;              // milliseconds
  bool idle_before = false;  // extraction had nothing to do when the frame was handed over
  Duration extracted;        // since the frame, before the slice is offered
  bool skipped_before = false;
  Action action;
  bool skips;
};
void PrintTo(const OverloadCase& c, std::ostream* out) {
  *out << c.name;
}
class FrameScheduleOverload : public testing::TestWithParam<OverloadCase> {};

TEST_P(FrameScheduleOverload, Rule) {
  const auto& c = GetParam();
  auto options = desk_options();
  options.frame = ms(18);  // one is done at 19.5, the next is to start at 21.5
  Desk desk(options);
  ASSERT_EQ(desk.draw(ms(18)), at(20));
  ASSERT_EQ(desk.now, at_us(19'500));
  if (c.idle_before) {
    ASSERT_EQ(desk.ask().action, Action::wait_until);
    desk.now = desk.now + us(50);
  }
  if (c.skipped_before) {
    const Slice oversize{0, 20};
    ASSERT_TRUE(desk.ask(oversize).skipped_frame);
    desk.slice(oversize, us(10));
    desk.now = at_us(41'500) - us(500);  // half a millisecond before the frame
  }
  if (c.extracted > Duration{}) {
    const Slice small{0, c.extracted.seconds() * 1e3};
    ASSERT_EQ(desk.ask(small).action, Action::run_slice);
    desk.slice(small, c.extracted);
  }
  const auto before = desk.schedule.statistics();
  const auto decision = desk.ask(Slice{0, c.slice});
  EXPECT_EQ(decision.action, c.action);
  EXPECT_EQ(decision.skipped_frame, c.skips);
  EXPECT_EQ(desk.schedule.statistics().skipped - before.skipped, c.skips ? 1 : 0);
}

INSTANTIATE_TEST_SUITE_P(
    Table, FrameScheduleOverload,
    testing::Values(OverloadCase{"SliceFits", 2, false, {}, false, Action::run_slice, false},
                    OverloadCase{"SliceDoesNotFit", 2.001, false, {}, false, Action::run_slice, true},
                    OverloadCase{"SliceLongerThanThePeriod", 30, false, {}, false, Action::run_slice, true},
                    OverloadCase{"TooLittleExtracted", 3, false, us(99), false, Action::run_slice, true},
                    OverloadCase{"EnoughExtracted", 3, false, us(100), false, Action::wait_until, false},
                    OverloadCase{"WorkCameAfterTheFrame", 3, true, {}, false, Action::wait_until, false},
                    OverloadCase{"FrameSkippedBefore", 3, false, {}, true, Action::wait_until, false}),
    [](const auto& c) { return std::string(c.param.name); });

struct PatienceCase {
  int patience;
  std::int64_t skipped;
};
class FrameSchedulePatience : public testing::TestWithParam<PatienceCase> {};

TEST_P(FrameSchedulePatience, DecidesWhetherADisturbedFrameCostsAnother) {
  auto options = desk_options();
  options.patience = GetParam().patience;
  options.frame = ms(12);
  options.cost.ignored = 1;
  Desk desk(options);
  const Slice slice{0, 4};
  const auto extract_until_drawn = [&](Duration cost) {
    while (desk.ask(slice).action == Action::run_slice) desk.slice(slice, ms(4));
    desk.draw(cost, slice);
  };
  for (int i = 0; i < 20; ++i) extract_until_drawn(ms(12));
  extract_until_drawn(ms(17));  // until 4.5 ms after its deadline; the next is to start 3 ms later
  for (int i = 0; i < 20; ++i) extract_until_drawn(ms(12));
  EXPECT_EQ(desk.schedule.statistics().skipped, GetParam().skipped);
  EXPECT_GE(desk.schedule.statistics().slices, 40);
}

INSTANTIATE_TEST_SUITE_P(Table, FrameSchedulePatience, testing::Values(PatienceCase{1, 1}, PatienceCase{2, 0}));

TEST(FrameSchedule, WithPatienceOverloadSkipsAFrameAfterSoManyGaps) {
  auto options = desk_options();
  options.patience = 3;
  options.frame = ms(18);
  Desk desk(options);
  const Slice slice{0, 4};
  desk.draw(ms(18));
  for (int round = 0; round < 3; ++round) {
    for (int gap = 0; gap < 2; ++gap) {
      ASSERT_EQ(desk.ask(slice).action, Action::wait_until);
      desk.draw(ms(18), slice);
    }
    const auto decision = desk.ask(slice);
    ASSERT_EQ(decision.action, Action::run_slice);
    ASSERT_TRUE(decision.skipped_frame);
    desk.slice(slice, ms(4));
    desk.draw(ms(18));
  }
  EXPECT_EQ(desk.schedule.statistics().skipped, 3);
}

TEST(FrameSchedule, ASkipGivesExtractionTheTimeUntilTheFrameAfter) {
  auto options = desk_options();
  options.frame = ms(18);
  Desk desk(options);
  desk.draw(ms(18));  // until 19.5; the frames after would start at 21.5, 41.5
  const Slice slice{0, 3};
  int slices = 0;
  for (auto decision = desk.ask(slice); decision.action == Action::run_slice; decision = desk.ask(slice)) {
    ASSERT_LT(slices, 100);
    EXPECT_EQ(decision.skipped_frame, slices == 0);
    desk.slice(slice, ms(3));
    ++slices;
  }
  EXPECT_EQ(slices, 7);
  EXPECT_EQ(desk.now, at_us(40'500));
  EXPECT_EQ(desk.draw(ms(18)), at(60));
  EXPECT_EQ(desk.schedule.statistics().skipped, 1);
  EXPECT_EQ(desk.schedule.statistics().missed, 0);
  EXPECT_EQ(desk.schedule.statistics().late, 0);
}

TEST(FrameSchedule, ASkipThatComesLateStillGrantsItsTime) {
  auto options = desk_options();
  options.period = ms(10);
  options.frame = ms(9);
  Desk desk(options);
  desk.draw(ms(11));  // begun at 0.5 with its deadline at 10, done at 11.5; the next should have begun at 10.5
  ASSERT_EQ(desk.now, at_us(11'500));
  const Slice slice{0, 5};
  ASSERT_TRUE(desk.ask(slice).skipped_frame);
  desk.slice(slice, ms(5));
  // The frame after should start at 20.5, before the second slice is done; extraction was granted the time until 21.5.
  auto decision = desk.ask(slice);
  EXPECT_EQ(decision.action, Action::run_slice);
  EXPECT_FALSE(decision.skipped_frame);
  desk.slice(slice, ms(5));
  decision = desk.ask(slice);
  EXPECT_EQ(decision.action, Action::draw_frame);
  EXPECT_EQ(decision.until, at(30));
}

TEST(FrameSchedule, AGrantIsNoLongerThanThePeriod) {
  auto options = desk_options();
  options.period = ms(5);
  options.frame = us(4'000);
  Desk desk(options);
  desk.draw(ms(4));  // 0.5 to 4.5
  const Slice slice{0, 2.1};
  ASSERT_TRUE(desk.ask(slice).skipped_frame);
  desk.slice(slice, us(2'100));
  EXPECT_EQ(desk.ask(slice).action, Action::run_slice);
  desk.slice(slice,
             us(2'100));  // until 8.7; granted until 9.5, where t_min would be until 14.5; the frame starts at 10.5
  EXPECT_EQ(desk.ask(slice).action, Action::wait_until);
  EXPECT_EQ(desk.draw(ms(4)), at(15));
  EXPECT_EQ(desk.schedule.statistics().late, 0);
  EXPECT_EQ(desk.schedule.statistics().skipped, 1);
}

TEST(FrameSchedule, AnOversizeSliceRunsAndTheDeadlinesItPassesAreGivenUpBeforehand) {
  Desk desk(desk_options());
  desk.draw(ms(5));  // until 19.5
  const Slice oversize{0, 55};
  const auto decision = desk.ask(oversize);
  ASSERT_EQ(decision.action, Action::run_slice);
  EXPECT_TRUE(decision.skipped_frame);
  EXPECT_EQ(desk.schedule.deadline(), at(80)) << "the first that a frame begun at 74.5 meets";
  desk.slice(oversize, ms(55));
  EXPECT_EQ(desk.draw(ms(5)), at(80));
  const auto& statistics = desk.schedule.statistics();
  EXPECT_EQ(statistics.oversize_slices, 1);
  EXPECT_EQ(statistics.skipped, 1);
  EXPECT_EQ(statistics.missed, 1);
  EXPECT_EQ(statistics.late, 0);
  EXPECT_EQ(statistics.due, 4);
}

TEST(FrameSchedule, AnOversizeSliceThatIsQuickerGivesTheDeadlinesBack) {
  Desk desk(desk_options());
  desk.draw(ms(5));
  const Slice oversize{0, 75};
  ASSERT_TRUE(desk.ask(oversize).skipped_frame);
  EXPECT_EQ(desk.schedule.deadline(), at(100));
  desk.slice(oversize, ms(10));
  EXPECT_EQ(desk.draw(ms(5)), at(60)) << "the one at 40 was skipped";
  EXPECT_EQ(desk.schedule.statistics().missed, 0);
}

struct OverrunCase {
  const char* name;
  Duration took;  // a slice that was reckoned at 10 ms and begun 14.5 ms before the frame's start
  std::int64_t deadline_ms, late, missed;
  Duration lateness;
};
void PrintTo(const OverrunCase& c, std::ostream* out) {
  *out << c.name;
}
class FrameScheduleOverrun : public testing::TestWithParam<OverrunCase> {};

TEST_P(FrameScheduleOverrun, Rule) {
  const auto& c = GetParam();
  Desk desk(desk_options());
  const Slice slice{0, 10};
  ASSERT_EQ(desk.ask(slice).action, Action::run_slice);
  desk.slice(slice, c.took);
  EXPECT_EQ(desk.draw(ms(5)), at(c.deadline_ms));
  const auto& statistics = desk.schedule.statistics();
  EXPECT_EQ(statistics.late, c.late);
  EXPECT_EQ(statistics.missed, c.missed);
  EXPECT_EQ(statistics.worst_lateness, c.lateness);
  EXPECT_EQ(statistics.slice_overruns, c.took > ms(10) ? 1 : 0);
}

INSTANTIATE_TEST_SUITE_P(Table, FrameScheduleOverrun,
                         testing::Values(OverrunCase{"Within", ms(10), 20, 0, 0, {}},
                                         OverrunCase{"IntoTheRoomLeft", us(14'500), 20, 0, 0, {}},
                                         OverrunCase{"IntoTheMargin", us(15'000), 20, 0, 0, {}},
                                         OverrunCase{"Late", us(15'001), 20, 1, 0, us(1)},
                                         OverrunCase{"AQuarterPeriodLateWithMargin", us(19'500), 20, 1, 0, us(4'500)},
                                         OverrunCase{"Later", us(19'501), 40, 0, 1, {}},
                                         OverrunCase{"SeveralPeriods", ms(70), 80, 0, 3, {}}),
                         [](const auto& c) { return std::string(c.param.name); });

TEST(FrameSchedule, FramesThatCostMoreThanThePeriodTakeEverySecondDeadlineAndComeBack) {
  Desk desk(desk_options());
  // Until the median knows, they are late or miss deadlines, but they do not drift.
  for (int i = 0; i < 20; ++i) {
    desk.draw(ms(26));
  }
  EXPECT_EQ(desk.schedule.submultiple(), 2);
  const auto before = desk.schedule.statistics();
  Timestamp last = desk.draw(ms(26));
  for (int i = 0; i < 50; ++i) {
    const Timestamp deadline = desk.draw(i % 10 == 9 ? ms(3) : ms(26));  // quick ones do not hurry the next
    EXPECT_EQ(deadline - last, ms(40));
    last = deadline;
  }
  EXPECT_EQ(desk.schedule.statistics().late, before.late);
  EXPECT_EQ(desk.schedule.statistics().missed - before.missed, 51);
  EXPECT_EQ(desk.schedule.statistics().frames - before.frames, 51);

  for (int i = 0; i < 40; ++i) {
    desk.draw(us(18'500));  // would do, but not by a tenth
  }
  EXPECT_EQ(desk.schedule.submultiple(), 2);
  for (int i = 0; i < 17; ++i) {
    last = desk.draw(ms(17));
  }
  EXPECT_EQ(desk.schedule.submultiple(), 1);
  EXPECT_EQ(desk.draw(ms(17)) - last, ms(20));
}

TEST(FrameSchedule, SingleFramesThatCostMoreThanThePeriodDoNotSlowTheOthers) {
  Desk desk(desk_options());
  for (int i = 0; i < 200; ++i) {
    desk.draw(i % 8 == 7 ? ms(22) : ms(5));
    EXPECT_EQ(desk.schedule.submultiple(), 1);
    EXPECT_EQ(desk.schedule.frame_cost(), ms(5)) << "no room is taken from extraction for what cannot be saved";
  }
  EXPECT_EQ(desk.schedule.statistics().late, 25 + 24) << "these, and by 1.5 ms those that follow them";
  EXPECT_EQ(desk.schedule.statistics().missed, 0);
  EXPECT_EQ(desk.schedule.statistics().worst_lateness, us(16'500));
}

TEST(FrameSchedule, BacklogIsCaughtUpWithoutDrift) {
  auto options = desk_options();
  options.frame = ms(15);
  Desk desk(options);
  EXPECT_EQ(desk.draw(ms(26)), at(20));  // 4.5 to 30.5: 10.5 ms late; the next should have begun at 24.5
  EXPECT_EQ(desk.draw(ms(15)), at(60));  // would have been 5.5 ms late for 40, more than a quarter of the period
  EXPECT_EQ(desk.schedule.statistics().missed, 1);
  EXPECT_EQ(desk.draw(ms(23)), at(80));   // 64.5 to 87.5
  EXPECT_EQ(desk.draw(ms(15)), at(100));  // 87.5 to 102.5: 2.5 ms late
  EXPECT_EQ(desk.draw(ms(15)), at(120));
  EXPECT_EQ(desk.now, at_us(119'500));
  EXPECT_EQ(desk.schedule.statistics().missed, 1);
  EXPECT_EQ(desk.schedule.statistics().late, 3);
}

TEST(FrameSchedule, FramesThatFillThePeriodDoNotCarryADelayOn) {
  auto options = desk_options();
  options.frame = us(19'500);
  Desk desk(options);
  desk.draw(us(19'500));
  EXPECT_EQ(desk.draw(us(20'600)), at(40));
  EXPECT_EQ(desk.schedule.statistics().late, 1);
  for (int i = 4; i < 100; ++i) {
    EXPECT_EQ(desk.draw(us(19'500)), at(i * 20));
  }
  EXPECT_EQ(desk.schedule.statistics().late, 1);
  EXPECT_EQ(desk.schedule.statistics().missed, 1) << "the one at 60";
}

TEST(FrameSchedule, APeriodMayChangeWhileRunning) {
  Desk desk(desk_options());
  EXPECT_EQ(desk.draw(ms(5)), at(20));
  desk.schedule.set_period(ms(30), desk.now);
  EXPECT_EQ(desk.draw(ms(5)), at(50));
  EXPECT_EQ(desk.draw(ms(5)), at(80));
  desk.now = at(95);
  desk.schedule.set_period(ms(10), desk.now);
  EXPECT_EQ(desk.draw(ms(5)), at_us(100'500)) << "90 cannot be met any more, and was never due";
  EXPECT_EQ(desk.draw(ms(5)), at_us(110'500));
  EXPECT_EQ(desk.schedule.statistics().late, 0);
  EXPECT_EQ(desk.schedule.statistics().missed, 0);
  EXPECT_EQ(desk.schedule.statistics().due, 5);
}

TEST(FrameSchedule, APeriodThatChangesAtEveryFramesStartPutsNoFrameOff) {
  Desk desk(desk_options());
  for (int i = 0; i < 100; ++i) {
    desk.now = desk.schedule.frame_start() + us(10);
    desk.schedule.set_period(us(20'000 - 50 * i), desk.now);
    ASSERT_EQ(desk.ask().action, Action::draw_frame) << i;
    desk.draw(ms(5));
  }
  EXPECT_EQ(desk.schedule.statistics().missed, 0);
}

TEST(FrameSchedule, APeriodMayChangeWhileAFrameIsDrawn) {
  Desk desk(desk_options());
  desk.now = desk.ask().until;
  const auto frame = desk.schedule.frame_started(desk.now);
  desk.schedule.set_period(ms(30), desk.now + ms(1));
  desk.now = at_us(20'200);
  desk.schedule.frame_handed_over(desk.now);
  desk.schedule.frame_completed(frame, desk.now);
  EXPECT_EQ(desk.schedule.statistics().worst_lateness, us(200)) << "it keeps its deadline";
  EXPECT_EQ(desk.draw(ms(5)), at(50));
}

TEST(FrameSchedule, TheGridCanBeLaidOnTheDisplaysInstants) {
  Desk desk(desk_options());
  desk.draw(ms(5));
  // Small corrections, as a display's instants ask for, neither double nor lose a frame.
  for (int i = 1; i <= 50; ++i) {
    const Timestamp instant = at_us(i * 20'010 + (i % 2 == 0 ? 30 : -30));
    desk.schedule.set_grid(us(20'010), instant, desk.now);
    EXPECT_EQ(desk.draw(ms(5)), instant + us(20'010));
  }
  desk.schedule.set_grid(ms(20), at(7), desk.now);
  EXPECT_EQ(desk.schedule.deadline().nanoseconds % 20'000'000, 7'000'000);
  EXPECT_EQ(desk.schedule.statistics().missed, 0);
  EXPECT_EQ(desk.schedule.statistics().late, 0);
}

TEST(FrameSchedule, ADeadlineThatMovesAfterItWasServedIsNotServedAgain) {
  Desk desk(desk_options());
  EXPECT_EQ(desk.draw(ms(1)), at(20));
  ASSERT_EQ(desk.now, at_us(15'500));
  desk.schedule.set_grid(ms(20), at(22), desk.now);
  EXPECT_EQ(desk.draw(ms(5)), at(42));
}

TEST(FrameSchedule, ASwapThatBlocksMakesFramesLateButNotCostly) {
  // The display shows at 3 ms after each deadline; a driver that takes the swap's return for the frame's completion.
  Desk desk(desk_options());
  for (int i = 1; i <= 100; ++i) {
    desk.now = desk.ask().until;
    ASSERT_EQ(desk.ask().action, Action::draw_frame);
    const auto frame = desk.schedule.frame_started(desk.now);
    desk.now = desk.now + ms(4);
    desk.schedule.frame_handed_over(desk.now);
    desk.now = at(20 * i + 3);
    desk.schedule.frame_completed(frame, desk.now);
  }
  EXPECT_EQ(desk.schedule.statistics().late, 100);
  EXPECT_EQ(desk.schedule.statistics().worst_lateness, ms(3));
  EXPECT_EQ(desk.schedule.frame_cost(), ms(4));
  // Deadlines laid behind the display's instants by what the swap takes, the margin enlarged: in time.
  auto options = desk_options();
  options.margin = us(1'000);
  Desk laid(options);
  laid.schedule.set_grid(ms(20), at_us(23'500), laid.now);
  for (int i = 1; i <= 100; ++i) {
    laid.now = laid.ask().until;
    const auto frame = laid.schedule.frame_started(laid.now);
    laid.now = laid.now + ms(4);
    laid.schedule.frame_handed_over(laid.now);
    laid.now = at_us(20'000 * i + 3'200);
    laid.schedule.frame_completed(frame, laid.now);
  }
  EXPECT_EQ(laid.schedule.statistics().late, 0);
  EXPECT_EQ(laid.schedule.statistics().missed, 0);
}

TEST(FrameSchedule, ACompletionMayBeReportedAfterTheNextFrameBegan) {
  Desk desk(desk_options());
  std::vector<std::int64_t> numbers;
  for (int i = 1; i <= 6; ++i) {
    desk.now = desk.ask().until;
    numbers.push_back(desk.schedule.frame_started(desk.now));
    desk.now = desk.now + ms(5);
    desk.schedule.frame_handed_over(desk.now);
  }
  desk.schedule.frame_completed(numbers[5], at(121));  // due at 120
  desk.schedule.frame_completed(numbers[2], at(62));   // due at 60
  desk.schedule.frame_completed(numbers[3], at(80));
  desk.schedule.frame_completed(numbers[0], at(500));  // more than four frames ago: not known any more
  desk.schedule.frame_completed(numbers[2], at(500));  // reported already
  EXPECT_EQ(desk.schedule.statistics().late, 2);
  EXPECT_EQ(desk.schedule.statistics().worst_lateness, ms(2));
}

struct JumpCase {
  const char* name;
  Duration by;
  std::int64_t stops;
};
void PrintTo(const JumpCase& c, std::ostream* out) {
  *out << c.name;
}
class FrameScheduleJump : public testing::TestWithParam<JumpCase> {};

/// The clock jumps while waiting, in a slice and in a frame: nothing is late or missed, and the grid keeps its phase.
TEST_P(FrameScheduleJump, IsAStop) {
  const Duration by = GetParam().by;
  const Slice slice{0, 2};
  for (const auto* where : {"waiting", "slice", "frame"}) {
    SCOPED_TRACE(where);
    Desk desk(desk_options(), at(100'000));
    desk.draw(ms(5));
    ASSERT_EQ(desk.ask(slice).action, Action::run_slice);
    desk.schedule.slice_started(slice, desk.now);
    desk.now = desk.now + ms(2) + (where == std::string("slice") ? by : Duration{});
    desk.schedule.slice_completed(desk.now);
    const Timestamp start = desk.ask().until;
    desk.now = start + (where == std::string("waiting") ? by : Duration{});
    Timestamp deadline;
    if (where == std::string("waiting")) {
      deadline = desk.draw(ms(5));
    } else {
      const auto frame = desk.schedule.frame_started(desk.now);
      desk.now = desk.now + ms(5) + (where == std::string("frame") ? by : Duration{});
      desk.schedule.frame_handed_over(desk.now);
      desk.schedule.frame_completed(frame, desk.now);
    }
    const Timestamp asked = desk.now;
    deadline = desk.draw(ms(5));
    EXPECT_LE(deadline - asked, ms(40)) << "goes on at once";
    EXPECT_EQ(deadline.nanoseconds % 20'000'000, 0);
    EXPECT_EQ(desk.draw(ms(5)), deadline + ms(20));
    const auto& statistics = desk.schedule.statistics();
    EXPECT_EQ(statistics.stops, GetParam().stops);
    EXPECT_EQ(statistics.late, 0);
    EXPECT_EQ(statistics.missed, 0);
    EXPECT_EQ(statistics.due, statistics.frames);
    EXPECT_LE(statistics.extraction, us(1'004'000));
    EXPECT_EQ(desk.schedule.frame_cost(), ms(5)) << "one outlier teaches nothing";
    EXPECT_EQ(desk.schedule.cost(slice), ms(2));
  }
}

INSTANTIATE_TEST_SUITE_P(Table, FrameScheduleJump,
                         testing::Values(JumpCase{"None", ms(0), 0}, JumpCase{"Suspended", ms(3'600'000), 1},
                                         JumpCase{"JustOverASecond", ms(1'001), 1}, JumpCase{"Back", ms(-50'003), 1}),
                         [](const auto& c) { return std::string(c.param.name); });

TEST(FrameSchedule, AClockThatGoesBackEndsWhatExtractionWasGranted) {
  auto options = desk_options();
  options.frame = ms(18);
  Desk desk(options, at(100'000));
  desk.draw(ms(18));
  ASSERT_TRUE(desk.ask(Slice{0, 3}).skipped_frame);
  desk.now = at(50'000);
  desk.slice({0, 3}, ms(3));
  EXPECT_EQ(desk.ask(Slice{0, 30}).action, Action::draw_frame);
  EXPECT_EQ(desk.schedule.statistics().stops, 1);
}

TEST(FrameSchedule, LessThanASecondIsNoStopButMissedDeadlines) {
  Desk desk(desk_options());
  desk.draw(ms(5));
  desk.now = desk.ask().until + ms(900);
  desk.draw(ms(5));
  EXPECT_EQ(desk.schedule.statistics().stops, 0);
  EXPECT_EQ(desk.schedule.statistics().missed, 45);
}

TEST(FrameSchedule, WhatIsKnownToTakeLongIsNoStop) {
  auto options = desk_options();
  options.period = ms(8'000);
  options.frame = ms(1'500);
  Desk desk(options);
  for (int i = 1; i < 5; ++i) {
    const Slice slice{0, 1'200};
    ASSERT_EQ(desk.ask(slice).action, Action::run_slice);
    desk.slice(slice, ms(1'200));
    EXPECT_EQ(desk.draw(ms(1'500)), at(8'000 * i));
  }
  EXPECT_EQ(desk.schedule.statistics().stops, 0);
  EXPECT_EQ(desk.schedule.statistics().extraction, ms(4'800));
}

TEST(FrameSchedule, KnowsWhatSlicesUsuallyTakeBesideWhatToReckonWith) {
  Desk desk(desk_options());
  for (int i = 0; i < 40; ++i) desk.slice({1, 0.5}, i % 4 == 0 ? us(2'200) : us(1'100));
  EXPECT_EQ(desk.schedule.cost({1, 0.5}), us(2'200));
  EXPECT_NEAR(desk.schedule.size_within(1, us(2'200)), 0.5, 1e-3);
  EXPECT_NEAR(desk.schedule.typical_size_within(1, us(1'100)), 0.5, 1e-3);
}

TEST(FrameSchedule, OtherKindsOfSlicesBeginAsDeclared) {
  Desk desk(desk_options());
  for (int i = 0; i < 40; ++i) desk.slice({1, 0.5}, us(550));
  desk.schedule.set_slices({{us(300), us(0)}});
  EXPECT_EQ(desk.schedule.cost({0, 1}), us(300));
}

TEST(FrameSchedule, CostsAreLearntByKindAndSize) {
  Desk desk(desk_options());
  EXPECT_EQ(desk.schedule.cost({1, 0.5}), us(1'100)) << "as declared";
  for (int i = 0; i < 40; ++i) {
    desk.slice({1, 0.5}, us(550));
  }
  EXPECT_EQ(desk.schedule.cost({1, 0.5}), us(550));
  EXPECT_EQ(desk.schedule.cost({1, 2}), us(2'050));
  EXPECT_EQ(desk.schedule.cost({0, 1}), us(1'000)) << "the other kind is as declared";
  for (const double milliseconds : {0.1, 1.0, 2.5, 7.3}) {
    const Duration room = Duration::from_seconds(milliseconds * 1e-3);
    const double size = desk.schedule.size_within(1, room);
    EXPECT_LE(desk.schedule.cost({1, size}), room);
    EXPECT_GE(desk.schedule.cost({1, size * 1.001 + 1e-4}), room);
  }
  EXPECT_EQ(desk.schedule.size_within(1, us(50)), 0) << "less than the constant part";
}

TEST(FrameSchedule, AWrongGuessIsCorrectedEvenWhereNothingSeemedToFit) {
  auto options = desk_options();
  options.slices = {{us(0), ms(300)}};  // a hundred times too much
  Desk desk(options);
  std::int64_t frames = 0;
  while (desk.schedule.cost({0, 1}) > ms(3)) {
    const auto decision = desk.ask(Slice{});
    if (decision.action == Action::run_slice) {
      desk.slice({}, ms(3));
    } else {
      desk.draw(ms(5));
      ++frames;
    }
    ASSERT_LT(frames, 100);
  }
  EXPECT_LT(frames, 40);
  EXPECT_EQ(desk.schedule.statistics().late, 0);
}

}  // namespace
}  // namespace foreview
