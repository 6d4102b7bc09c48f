#include "foreview/server/simulated_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr Duration ms(std::int64_t count) {
  return {count * 1'000'000};
}
constexpr Timestamp at_ms(std::int64_t count) {
  return {count * 1'000'000};
}

/// Delays in seconds of `count` packets sent every 10 ms; lost ones left out.
std::vector<double> delays_of(SimulatedLink& link, int count, std::size_t bytes = 1000) {
  std::vector<double> delays;
  for (int i = 0; i < count; ++i) {
    if (const auto arrival = link.send(at_ms(10 * i), bytes)) delays.push_back((*arrival - at_ms(10 * i)).seconds());
  }
  return delays;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

std::string error_of(const LinkOptions& options) {
  try {
    check_link_options(options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SimulatedLink, DelaysByAConstant) {
  SimulatedLink link({.delay = ms(250)});
  EXPECT_EQ(link.send(at_ms(1000), 12345), at_ms(1250));
  EXPECT_EQ(link.send(at_ms(1000), 0), at_ms(1250));
}

TEST(SimulatedLink, JitterHasTheDeviationAskedForAndNothingArrivesBeforeItWasSent) {
  SimulatedLink link({.delay = ms(500), .jitter = ms(50)});
  const std::vector<double> delays = delays_of(link, 20000);
  EXPECT_NEAR(mean(delays), 0.5, 0.002);
  EXPECT_NEAR(deviation(delays), 0.05, 0.001);
  // Of a normal distribution, 2.3 % lie beyond two deviations on either side.
  const auto beyond = std::count_if(delays.begin(), delays.end(), [](double d) { return d > 0.6; });
  EXPECT_NEAR(static_cast<double>(beyond) / 20000, 0.0228, 0.004);

  SimulatedLink nervous({.delay = ms(10), .jitter = ms(200)});
  const std::vector<double> clipped = delays_of(nervous, 1000);
  EXPECT_EQ(*std::min_element(clipped.begin(), clipped.end()), 0);
}

TEST(SimulatedLink, LosesTheShareAskedFor) {
  SimulatedLink link({.loss = 0.2});
  EXPECT_NEAR(static_cast<double>(delays_of(link, 20000).size()) / 20000, 0.8, 0.01);
  SimulatedLink none({.loss = 1});
  EXPECT_TRUE(delays_of(none, 100).empty());
}

TEST(SimulatedLink, ReordersOrKeepsOrder) {
  LinkOptions options{.delay = ms(100), .reordering = 0.1, .reordering_delay = ms(25)};
  SimulatedLink link(options);
  std::size_t overtaken = 0;
  Timestamp latest;
  for (int i = 0; i < 10000; ++i) {
    const Timestamp arrival = link.send(at_ms(10 * i), 1).value();
    overtaken += arrival < latest;
    latest = std::max(latest, arrival);
  }
  // Each packet held back is overtaken by the next two, unless these are held back too.
  EXPECT_NEAR(static_cast<double>(overtaken) / 10000, 0.171, 0.02);

  options.in_order = true;
  SimulatedLink ordered(options);
  latest = {};
  for (int i = 0; i < 10000; ++i) {
    const Timestamp arrival = ordered.send(at_ms(10 * i), 1).value();
    EXPECT_GE(arrival, latest);
    latest = arrival;
  }
}

TEST(SimulatedLink, PacketsQueueForTheBandwidth) {
  // 8 kbit/s: a byte takes a millisecond.
  SimulatedLink link({.delay = ms(100), .bandwidth = 8000, .longest_queue = ms(50)});
  EXPECT_EQ(link.send(at_ms(0), 40), at_ms(140));
  EXPECT_EQ(link.send(at_ms(10), 30), at_ms(170));   // waits 30 ms
  EXPECT_EQ(link.send(at_ms(19), 1), std::nullopt);  // would wait 51 ms
  EXPECT_EQ(link.send(at_ms(20), 1), at_ms(171));    // the one before takes no room
  EXPECT_EQ(link.send(at_ms(200), 5), at_ms(305));   // the queue has emptied
}

TEST(SimulatedLink, DrawsFromMeasuredDelays) {
  SimulatedLink link({.delay = ms(1), .jitter = ms(1), .measured_delays = {ms(200), ms(300), ms(700)}});
  const std::vector<double> delays = delays_of(link, 9000);
  for (const double delay : {0.2, 0.3, 0.7}) {
    const auto count =
        std::count_if(delays.begin(), delays.end(), [&](double d) { return std::abs(d - delay) < 1e-9; });
    EXPECT_NEAR(static_cast<double>(count) / 9000, 1 / 3.0, 0.02);
  }
}

TEST(SimulatedLink, TheSameSeedGivesTheSameLink) {
  const LinkOptions options{.delay = ms(100), .jitter = ms(20), .loss = 0.3, .reordering = 0.2, .seed = 7};
  SimulatedLink a(options), b(options);
  LinkOptions other = options;
  other.seed = 8;
  SimulatedLink c(other);
  const std::vector<double> delays = delays_of(a, 500);
  EXPECT_EQ(delays, delays_of(b, 500));
  EXPECT_NE(delays, delays_of(c, 500));
  // Written down once: the same on every machine and in every year.
  SimulatedLink known({.delay = ms(100), .jitter = ms(20), .seed = 7});
  const double first = (known.send(at_ms(0), 1).value() - at_ms(0)).seconds();
  EXPECT_NEAR(first, 0.121073399, 1e-9);
}

TEST(SimulatedLink, OptionsChangeWhileRunningWithoutChangingTheLuckOfOthers) {
  SimulatedLink steady({.delay = ms(100), .loss = 0.5});
  SimulatedLink changing({.delay = ms(100), .loss = 0.5});
  for (int i = 0; i < 200; ++i) {
    if (i == 100) changing.set_options({.delay = ms(300), .jitter = ms(5), .loss = 0.5});
    const auto a = steady.send(at_ms(i), 1), b = changing.send(at_ms(i), 1);
    EXPECT_EQ(a.has_value(), b.has_value()) << i;
    if (!a || !b) continue;
    if (i < 100) {
      EXPECT_EQ(*a, *b);
    } else {
      EXPECT_GT(*b - *a, ms(170));
    }
  }
}

TEST(SimulatedLink, RefusesWhatIsNoLink) {
  EXPECT_NE(error_of({.delay = ms(-1)}).find("link delay"), std::string::npos);
  EXPECT_NE(error_of({.jitter = ms(-1)}).find("link jitter"), std::string::npos);
  EXPECT_NE(error_of({.loss = 1.1}).find("link loss"), std::string::npos);
  EXPECT_NE(error_of({.loss = std::nan("")}).find("link loss"), std::string::npos);
  EXPECT_NE(error_of({.bandwidth = -1}).find("link bandwidth"), std::string::npos);
  EXPECT_NE(error_of({.bandwidth = std::numeric_limits<double>::infinity()}).find("bandwidth"), std::string::npos);
  EXPECT_EQ(error_of({}), "");
  // A modem of one bit in a thousand years must not leave the range of time.
  SimulatedLink slow({.bandwidth = 1e-300});
  EXPECT_GT(slow.send(at_ms(0), 1), at_ms(0));
}

TEST(MeasuredDelays, AreReadAndWrongOnesAreNamed) {
  EXPECT_EQ(parse_measured_delays("# ping\n231ms\n 0.25 \r\n\n40us # good\n", "f"),
            (std::vector<Duration>{ms(231), ms(250), Duration{40'000}}));
  const auto error = [](const char* text) -> std::string {
    try {
      static_cast<void>(parse_measured_delays(text, "delays.txt"));
    } catch (const InputError& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_NE(error("1ms\nfast\n").find("delays.txt:2"), std::string::npos);
  EXPECT_NE(error("-1ms\n").find("delays.txt:1"), std::string::npos);
  EXPECT_NE(error("2h\n").find("delays.txt:1"), std::string::npos);
  EXPECT_NE(error("4000 s\n").find("expected 0 to 3600 s"), std::string::npos);
  EXPECT_NE(error("# nothing\n").find("holds no delay"), std::string::npos);
}

}  // namespace
}  // namespace foreview
