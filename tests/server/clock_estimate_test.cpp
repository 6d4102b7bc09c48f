#include "foreview/server/clock_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr double kMs = 1e6, kSecond = 1e9;

constexpr Duration ms(std::int64_t count) {
  return {count * 1'000'000};
}

/// What is sent by a robot whose clock drifts, over a link with a floor. Times of the truth are the operator's, in
/// nanoseconds since the beginning.
struct World {
  std::mt19937_64 random{1};
  double drift = 0;
  double floor = 80 * kMs;
  double rate = 30, loss = 0.2;
  std::function<double(World&)> jitter = [](World& world) { return world.uniform(0, 200 * kMs); };
  std::function<double(double)> clock_step = [](double) { return 0.0; };   ///< added to the robot's clock
  std::function<double(double)> extra_delay = [](double) { return 0.0; };  ///< by the time of sending
  std::function<bool(double)> is_silent = [](double) { return false; };
  Timestamp robot_at_0{1'700'000'000'123'456'789}, operator_at_0{4'711'000'000'000};

  double uniform(double least, double most) { return std::uniform_real_distribution<double>(least, most)(random); }
  double exponential(double mean) { return std::exponential_distribution<double>(1 / mean)(random); }
  double normal(double deviation) { return std::normal_distribution<double>(0, deviation)(random); }

  [[nodiscard]] Timestamp stamp(double time) const {
    return {robot_at_0.nanoseconds + std::llround(time + drift * time + clock_step(time))};
  }
  [[nodiscard]] Timestamp operator_clock(double time) const { return {operator_at_0.nanoseconds + std::llround(time)}; }

  struct Packet {
    double sent = 0, arrival = 0;
  };
  std::vector<Packet> packets(double seconds) {
    std::vector<Packet> result;
    for (int i = 0; i < seconds * rate; ++i) {
      const double sent = i * kSecond / rate;
      const double delay = floor + jitter(*this) + extra_delay(sent);
      if (uniform(0, 1) < loss || is_silent(sent)) continue;
      result.push_back({sent, sent + delay});
    }
    std::sort(result.begin(), result.end(), [](const Packet& a, const Packet& b) { return a.arrival < b.arrival; });
    return result;
  }
  /// How far the moment of a stamp taken at `time` is off, nanoseconds; positive: taken for later than it was.
  [[nodiscard]] double error(const ClockEstimate& estimate, double time) const {
    const Timestamp moment = estimate.operator_time(stamp(time)).value();
    return static_cast<double>((moment - operator_clock(time + floor)).nanoseconds);
  }
};

struct Accuracy {
  double worst = 0, worst_drift = 0;
  std::vector<double> errors;
  std::size_t checks = 0, covered = 0;  ///< covered: errors within the uncertainty told
  ClockEstimate::State state;

  [[nodiscard]] double median() {
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    return errors[errors.size() / 2];
  }
};

/// Lets a world run; errors are looked at at every packet's arrival that lies in from..to seconds.
Accuracy run(World& world, ClockEstimate& estimate, double seconds, double from, double to = 1e9) {
  Accuracy accuracy;
  for (const World::Packet& packet : world.packets(seconds)) {
    const Timestamp arrival = world.operator_clock(packet.arrival);
    estimate.observe(world.stamp(packet.sent), arrival);
    if (packet.arrival < from * kSecond || packet.arrival > to * kSecond) continue;
    const double error = std::abs(world.error(estimate, packet.arrival));
    accuracy.state = estimate.state(arrival);
    accuracy.worst = std::max(accuracy.worst, error);
    accuracy.worst_drift = std::max(accuracy.worst_drift, std::abs(accuracy.state.drift - world.drift));
    accuracy.errors.push_back(error);
    ++accuracy.checks;
    accuracy.covered += error <= static_cast<double>(accuracy.state.uncertainty.nanoseconds);
  }
  return accuracy;
}

struct Jitter {
  const char* name;
  std::function<double(World&)> draw;
  double worst_ms, median_ms, late_worst_ms, late_drift, least_coverage;
};

TEST(ClockEstimate, IsAsAccurateAsItsHeaderSays) {
  // Of 40 runs each: the worst error from 20 s on, the worst run's median, the worst error and drift from 60 s on.
  const std::vector<Jitter> jitters = {
      {"none", [](World&) { return 0.0; }, 0.001, 0.001, 0.001, 1e-7, 1},
      {"uniform to 200 ms", [](World& w) { return w.uniform(0, 200 * kMs); }, 5, 1, 5, 120e-6, 0.93},
      {"exponential, mean 30 ms", [](World& w) { return w.exponential(30 * kMs); }, 1.5, 0.2, 1.2, 40e-6, 0.92},
      {"half normal, 200 ms", [](World& w) { return std::abs(w.normal(200 * kMs)); }, 9, 1.5, 5, 120e-6, 0.93},
      {"two uniform to 100 ms", [](World& w) { return w.uniform(0, 100 * kMs) + w.uniform(0, 100 * kMs); }, 20, 12, 20,
       300e-6, 0.85},
  };
  for (const Jitter& jitter : jitters) {
    double worst = 0, median = 0, late_worst = 0, late_drift = 0;
    std::size_t checks = 0, covered = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      World world;
      world.random.seed(seed);
      world.drift = world.uniform(-100e-6, 100e-6);
      world.jitter = jitter.draw;
      ClockEstimate estimate({});
      const World again = world;
      Accuracy accuracy = run(world, estimate, 180, 20);
      EXPECT_EQ(accuracy.state.jumps, 0u) << jitter.name << ", seed " << seed;
      EXPECT_EQ(accuracy.state.outliers, 0u) << jitter.name << ", seed " << seed;
      worst = std::max(worst, accuracy.worst);
      median = std::max(median, accuracy.median());
      checks += accuracy.checks;
      covered += accuracy.covered;
      world = again;
      ClockEstimate second({});
      accuracy = run(world, second, 180, 60);
      late_worst = std::max(late_worst, accuracy.worst);
      late_drift = std::max(late_drift, accuracy.worst_drift);
    }
    const double coverage = static_cast<double>(covered) / static_cast<double>(checks);
    std::printf(
        "%-24s from 20 s: worst %.3f ms, median %.3f ms; from 60 s: worst %.3f ms, drift %.1f ppm; "
        "%.1f %% within the uncertainty\n",
        jitter.name, worst / kMs, median / kMs, late_worst / kMs, late_drift * 1e6, coverage * 100);
    EXPECT_LT(worst, jitter.worst_ms * kMs) << jitter.name;
    EXPECT_LT(median, jitter.median_ms * kMs) << jitter.name;
    EXPECT_LT(late_worst, jitter.late_worst_ms * kMs) << jitter.name;
    EXPECT_LT(late_drift, jitter.late_drift) << jitter.name;
    EXPECT_GE(coverage, jitter.least_coverage) << jitter.name;
  }
}

/// A jump of the robot's clock at 100 s, 20 % loss, 200 ms jitter; 20 runs. Errors from `settled` s after it.
void expect_jump_is_found(double jump_seconds, double settled, double worst_ms) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    World world;
    world.random.seed(seed);
    world.drift = world.uniform(-100e-6, 100e-6);
    world.clock_step = [&](double time) { return time < 100 * kSecond ? 0 : jump_seconds * kSecond; };
    ClockEstimate estimate({});
    const Accuracy accuracy = run(world, estimate, 160, 100 + settled);
    EXPECT_EQ(accuracy.state.jumps, 1u) << jump_seconds << " s, seed " << seed;
    EXPECT_EQ(accuracy.state.outliers, 0u) << jump_seconds << " s, seed " << seed;
    EXPECT_LT(accuracy.worst, worst_ms * kMs) << jump_seconds << " s, seed " << seed;
  }
}

TEST(ClockEstimate, FindsAClockSetForward) {
  for (const double jump : {0.8, 5.0, 3600.0, 1e8}) expect_jump_is_found(jump, 5, 25);
}

TEST(ClockEstimate, FindsAClockSetBack) {
  for (const double jump : {-0.9, -5.0, -3600.0, -1.7e9}) expect_jump_is_found(jump, 5, 25);
}

TEST(ClockEstimate, FindsASenderRestartedWhoseClockIsBehindByLessThanItWasAway) {
  // Stamps go on, yet everything seems 20 s late: only its lasting tells that from a queue.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    World world;
    world.random.seed(seed);
    world.clock_step = [](double time) { return time < 100 * kSecond ? 0 : -20 * kSecond; };
    world.is_silent = [](double time) { return time > 70 * kSecond && time < 100 * kSecond; };
    ClockEstimate estimate({});
    const Accuracy accuracy = run(world, estimate, 160, 116);
    EXPECT_EQ(accuracy.state.jumps, 1u) << seed;
    EXPECT_LT(accuracy.worst, 25 * kMs) << seed;
  }
}

TEST(ClockEstimate, FollowsSmallStepsWithoutBeginningAnew) {
  // Forward: at once. Back: when the window no longer holds what was before; until then it is taken for a delay.
  for (const double step : {50 * kMs, -50 * kMs}) {
    World world;
    world.clock_step = [=](double time) { return time < 100 * kSecond ? 0 : step; };
    const World again = world;
    ClockEstimate estimate({});
    Accuracy accuracy = run(world, estimate, 300, step > 0 ? 105 : 162);
    EXPECT_EQ(accuracy.state.jumps, 0u);
    EXPECT_LT(accuracy.worst, 30 * kMs) << step / kMs;
    world = again;
    ClockEstimate second({});
    accuracy = run(world, second, 300, 230);
    EXPECT_LT(accuracy.worst, 5 * kMs) << step / kMs;
    world = again;
    ClockEstimate third({});
    EXPECT_LT(run(world, third, 300, 20, 160).worst, 60 * kMs);
  }
}

TEST(ClockEstimate, ShowsALongerRouteAsLatencyWhileItRemembersTheShorterOne) {
  World world;
  world.extra_delay = [](double time) { return time > 100 * kSecond && time < 140 * kSecond ? 300 * kMs : 0; };
  world.jitter = [](World& w) { return w.uniform(0, 20 * kMs); };
  ClockEstimate estimate({});
  for (const World::Packet& packet : world.packets(200)) {
    const Timestamp arrival = world.operator_clock(packet.arrival), stamp = world.stamp(packet.sent);
    estimate.observe(stamp, arrival);
    if (packet.arrival < 20 * kSecond) continue;
    const double truth = packet.arrival - packet.sent - world.floor;
    ASSERT_NEAR(estimate.latency(stamp, arrival)->seconds(), truth / kSecond, 0.008) << packet.arrival / kSecond;
  }
  EXPECT_EQ(estimate.state({}).jumps, 0u);
}

TEST(ClockEstimate, AQueueThatBuildsUpAndDrainsIsLatencyAndNoJump) {
  World world;
  world.jitter = [](World& w) { return w.exponential(5 * kMs); };
  // Up to 8 s within 20 s, and down again: what bufferbloat, or an outage with a queue behind it, looks like.
  world.extra_delay = [](double time) {
    const double since = time / kSecond - 60;
    return kSecond * std::max(0.0, since < 20 ? since * 0.4 : 8 - (since - 20) * 0.4) * (since > 0 ? 1 : 0);
  };
  ClockEstimate estimate({});
  const Accuracy accuracy = run(world, estimate, 130, 20);
  EXPECT_EQ(accuracy.state.jumps, 0u);
  EXPECT_LT(accuracy.worst, 2 * kMs);
}

TEST(ClockEstimate, SilenceOnlyMakesItLessSure) {
  World world;
  world.drift = 80e-6;
  world.is_silent = [](double time) { return time > 60 * kSecond && time < 90 * kSecond; };
  ClockEstimate estimate({});
  for (const World::Packet& packet : world.packets(61)) {
    estimate.observe(world.stamp(packet.sent), world.operator_clock(packet.arrival));
  }
  const auto before = estimate.state(world.operator_clock(60 * kSecond));
  const auto after = estimate.state(world.operator_clock(90 * kSecond));
  EXPECT_GT(after.uncertainty, before.uncertainty);
  EXPECT_LT(std::abs(world.error(estimate, 90 * kSecond)), static_cast<double>(after.uncertainty.nanoseconds));

  World again;
  again.drift = 80e-6;
  again.is_silent = world.is_silent;
  ClockEstimate through({});
  const Accuracy accuracy = run(again, through, 200, 90);
  EXPECT_EQ(accuracy.state.jumps, 0u);
  EXPECT_LT(accuracy.worst, 5 * kMs);
}

TEST(ClockEstimate, DamagedStampsAreLeftOutAndCounted) {
  World world;
  world.jitter = [](World& w) { return w.exponential(10 * kMs); };
  ClockEstimate estimate({});
  std::size_t index = 0, ahead = 0;
  for (const World::Packet& packet : world.packets(120)) {
    const Timestamp arrival = world.operator_clock(packet.arrival);
    if (++index % 10 == 0) {
      const Timestamp garbage{static_cast<std::int64_t>(world.random())};
      estimate.observe(garbage, arrival);
      ahead += garbage > world.stamp(packet.sent);
    }
    estimate.observe(world.stamp(packet.sent), arrival);
    if (packet.arrival > 20 * kSecond) {
      ASSERT_LT(std::abs(world.error(estimate, packet.arrival)), 1 * kMs);
    }
  }
  const auto state = estimate.state(world.operator_clock(120 * kSecond));
  EXPECT_EQ(state.jumps, 0u);
  EXPECT_GT(ahead, 50u);
  EXPECT_GE(state.outliers + 3, ahead);  // the last may still be waiting for others that agree
  EXPECT_LE(state.outliers, ahead);
}

TEST(ClockEstimate, ReorderedAndDuplicatedPacketsAreNoJump) {
  World world;
  world.jitter = [](World& w) { return w.uniform(0, 1) < 0.1 ? w.uniform(0, 3 * kSecond) : w.exponential(10 * kMs); };
  ClockEstimate estimate({});
  for (const World::Packet& packet : world.packets(300)) {
    for (int copy = 0; copy < 2; ++copy) {
      estimate.observe(world.stamp(packet.sent), world.operator_clock(packet.arrival));
    }
    if (packet.arrival > 20 * kSecond) {
      ASSERT_LT(std::abs(world.error(estimate, packet.arrival)), 1 * kMs);
    }
  }
  EXPECT_EQ(estimate.state({}).jumps, 0u);
  EXPECT_EQ(estimate.state({}).outliers, 0u);
}

TEST(ClockEstimate, AFewLuckyPacketsAreTheLinksLuckAndNoJump) {
  World world;
  int drawn = 0;
  world.jitter = [&](World& w) {
    const bool is_lucky = ++drawn > 600 && w.uniform(0, 1) < 0.03;
    return is_lucky ? w.uniform(0, 10 * kMs) : w.uniform(800, 1000) * kMs;
  };
  ClockEstimate estimate({});
  const Accuracy accuracy = run(world, estimate, 120, 30);
  EXPECT_EQ(accuracy.state.jumps, 0u);
  EXPECT_EQ(accuracy.state.outliers, 0u);
  EXPECT_LT(accuracy.worst, 15 * kMs);
}

TEST(ClockEstimate, RandomWorldsWithJumpsAreFollowed) {
  std::mt19937_64 random(7);
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    World world;
    world.random.seed(seed);
    world.drift = world.uniform(-100e-6, 100e-6);
    world.floor = world.uniform(0, 600 * kMs);
    world.rate = world.uniform(10, 60);
    world.loss = world.uniform(0, 0.4);
    const double most = world.uniform(1, 200) * kMs;
    world.jitter = [=](World& w) { return w.uniform(0, most); };
    // Every 40 s a jump of 1 s to 1 day, either way.
    std::vector<double> steps{0};
    for (int i = 0; i < 4; ++i) {
      const double size = std::exp(world.uniform(0, std::log(86400.0))) * kSecond;
      steps.push_back(steps.back() + (world.uniform(0, 1) < 0.5 ? size : -size));
    }
    world.clock_step = [=](double time) {
      return steps[std::min<std::size_t>(static_cast<std::size_t>(time / (40 * kSecond)), steps.size() - 1)];
    };
    ClockEstimate estimate({});
    for (const World::Packet& packet : world.packets(200)) {
      estimate.observe(world.stamp(packet.sent), world.operator_clock(packet.arrival));
      const double since_jump = std::fmod(packet.arrival, 40 * kSecond);
      if (since_jump < 12 * kSecond || std::fmod(packet.sent, 40 * kSecond) > since_jump) continue;
      ASSERT_LT(std::abs(world.error(estimate, packet.arrival)), 0.15 * most + 1 * kMs)
          << "seed " << seed << " at " << packet.arrival / kSecond << " s";
    }
    EXPECT_EQ(estimate.state({}).jumps, 4u) << seed;
  }
}

TEST(ClockEstimate, ConvertsBothWaysToTheNanosecond) {
  World world;
  world.drift = -100e-6;
  world.jitter = [](World&) { return 0.0; };
  ClockEstimate estimate({.least_delay = ms(30)});
  EXPECT_EQ(estimate.operator_time({1}), std::nullopt);
  EXPECT_EQ(estimate.sender_time({1}), std::nullopt);
  EXPECT_EQ(estimate.latency({1}, {2}), std::nullopt);
  EXPECT_FALSE(estimate.state({}).is_known);
  for (const World::Packet& packet : world.packets(100)) {
    estimate.observe(world.stamp(packet.sent), world.operator_clock(packet.arrival));
  }
  // The floor is 80 ms; of these 30 are said to be the link's.
  for (const double time : {-1e12, 0.0, 100 * kSecond, 3600 * kSecond}) {
    const Timestamp moment = estimate.operator_time(world.stamp(time)).value();
    const double drift_of_extrapolation = std::abs(time - 100 * kSecond) * 1e-9;
    EXPECT_NEAR(static_cast<double>((moment - world.operator_clock(time + 50 * kMs)).nanoseconds), 0,
                100 + drift_of_extrapolation);
    const Timestamp back = estimate.sender_time(moment).value();
    EXPECT_NEAR(static_cast<double>((back - world.stamp(time)).nanoseconds), 0, 3);
  }
  EXPECT_NEAR(estimate.state({}).drift, -100e-6, 1e-9);
  const Duration latency = estimate.latency(world.stamp(99 * kSecond), world.operator_clock(100 * kSecond)).value();
  EXPECT_NEAR(latency.seconds(), 0.95, 1e-6);
  EXPECT_EQ(estimate.latency(world.stamp(99 * kSecond), world.operator_clock(90 * kSecond)), Duration{});
}

TEST(ClockEstimate, StampsOfAnyValueDoNoHarm) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  std::mt19937_64 random(3);
  for (const ClockMode mode : {ClockMode::estimated, ClockMode::synchronised}) {
    ClockEstimate estimate({.mode = mode});
    for (int i = 0; i < 20000; ++i) {
      const std::int64_t values[] = {kMost, kLeast, 0, 1, -1, static_cast<std::int64_t>(random())};
      const Timestamp stamp{values[random() % 6]}, arrival{values[random() % 6]};
      estimate.observe(stamp, arrival);
      EXPECT_TRUE(estimate.operator_time({values[random() % 6]}).has_value());
      EXPECT_TRUE(estimate.sender_time({values[random() % 6]}).has_value());
      EXPECT_GE(estimate.latency(stamp, arrival).value(), Duration{});
      EXPECT_GE(estimate.state(arrival).uncertainty, Duration{});
    }
  }
}

TEST(ClockEstimate, SynchronisedStampsAreTakenAsTheyAreWithAWordWhereTheyCannotBe) {
  ClockEstimate estimate({.mode = ClockMode::synchronised});
  const auto at = [](std::int64_t time_ms) { return Timestamp{1'700'000'000'000'000'000 + time_ms * 1'000'000}; };
  EXPECT_EQ(estimate.operator_time(at(5)), at(5));
  for (int i = 0; i < 100; ++i) estimate.observe(at(i * 33), at(i * 33 + 120));
  EXPECT_EQ(estimate.latency(at(3300), at(3420)), ms(120));
  EXPECT_EQ(estimate.sender_time(at(7)), at(7));
  EXPECT_EQ(estimate.state(at(3420)).warning, "");
  estimate.observe(at(4001), at(4000));  // what NTP leaves
  EXPECT_EQ(estimate.state(at(4000)).warning, "");
  estimate.observe(at(4250), at(4100));
  estimate.observe(at(4200), at(4101));
  EXPECT_EQ(estimate.state(at(4101)).warning, "stamps lie up to 150 ms in the future: the clocks are not synchronised");
  EXPECT_EQ(estimate.latency(at(4250), at(4100)), Duration{});
  EXPECT_EQ(estimate.state(at(4100 + 31'000)).warning, "");  // it has passed
}

TEST(ClockEstimate, AnOperatorsClockThatGoesBackBeginsAnew) {
  const auto at_frame = [](std::int64_t i) { return i * 33'000'000; };
  ClockEstimate estimate({});
  for (int i = 0; i < 100; ++i) estimate.observe({at_frame(i)}, {1'000'000'000'000 + at_frame(i)});
  estimate.observe({at_frame(100)}, {500'000'000'000});
  EXPECT_EQ(estimate.state({500'000'000'000}).jumps, 1u);
  EXPECT_EQ(estimate.operator_time({at_frame(100)}), Timestamp{500'000'000'000});
}

TEST(ClockEstimate, RefusesOptionsThatMakeNoSense) {
  const auto error = [](ClockEstimate::Options options) -> std::string {
    try {
      ClockEstimate estimate(options);
    } catch (const InputError& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_EQ(error({}), "");
  EXPECT_NE(error({.window = {}}).find("clock window"), std::string::npos);
  EXPECT_NE(error({.jump = ms(-1)}).find("clock jump"), std::string::npos);
  EXPECT_NE(error({.least_delay = ms(-1)}).find("least delay"), std::string::npos);
  EXPECT_NE(error({.most_drift = std::nan("")}).find("most drift"), std::string::npos);
}

}  // namespace
}  // namespace foreview
