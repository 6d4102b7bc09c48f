#include "foreview/viewer/link_options_cli.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

TEST(LinkOptionsCli, Bandwidths) {
  EXPECT_EQ(parse_bandwidth("8M", "--bandwidth"), 8e6);
  EXPECT_EQ(parse_bandwidth("500kbit/s", "--bandwidth"), 5e5);
  EXPECT_EQ(parse_bandwidth("64000", "--bandwidth"), 64000);
  EXPECT_EQ(parse_bandwidth("0", "--bandwidth"), 0);
  for (const char* wrong : {"", "M", "8m", "-8M", "8M/s", "1", "nan", "inf", "1e15", "8 M"}) {
    EXPECT_THROW((void)parse_bandwidth(wrong, "--bandwidth"), InputError) << wrong;
  }
}

TEST(LinkOptionsCli, Probabilities) {
  EXPECT_EQ(parse_probability("0.2", "--loss"), 0.2);
  EXPECT_EQ(parse_probability("20%", "--loss"), 0.2);
  EXPECT_EQ(parse_probability("100%", "--loss"), 1);
  for (const char* wrong : {"", "20", "-0.1", "1.1", "101%", "nan", "20 %", "%"}) {
    EXPECT_THROW((void)parse_probability(wrong, "--loss"), InputError) << wrong;
  }
}

TEST(LinkOptionsCli, IntoTheLink) {
  CLI::App app;
  LinkOptions options;
  add_link_options(app, options);
  app.parse("--jitter 50ms --loss 10% --bandwidth 2M --link-seed 7");
  EXPECT_EQ(options.jitter, Duration{50'000'000});
  EXPECT_EQ(options.loss, 0.1);
  EXPECT_EQ(options.bandwidth, 2e6);
  EXPECT_EQ(options.seed, 7U);
  CLI::App other;
  add_link_options(other, options);
  EXPECT_THROW(other.parse("--jitter -1s"), InputError);
}

}  // namespace
}  // namespace foreview
