#include "oracle/suppression.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace foreview::oracle {
namespace {

/// 1: '#', 0: '.', 31/32: 'o'.
AlphaImage image(const std::vector<std::string>& rows) {
  AlphaImage result(static_cast<int>(rows[0].size()), static_cast<int>(rows.size()));
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const char c = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
      result.at(x, y) = c == '#' ? 1 : c == 'o' ? kOutside : 0;
    }
  }
  return result;
}

std::vector<std::string> rows(const AlphaImage& alpha) {
  std::vector<std::string> result;
  for (int y = 0; y < alpha.height; ++y) {
    std::string row;
    for (int x = 0; x < alpha.width; ++x) {
      row += alpha.at(x, y) == 1 ? '#' : alpha.at(x, y) == kOutside ? 'o' : alpha.at(x, y) == 0 ? '.' : '?';
    }
    result.push_back(row);
  }
  return result;
}

AlphaImage full(int width, int height) {
  return AlphaImage(width, height, 1.0);
}

AlphaImage with_hole(int size, int x, int y) {
  AlphaImage result = full(size, size);
  result.at(x, y) = 0;
  return result;
}

std::ptrdiff_t invalid_texels(const AlphaImage& alpha) {
  return std::count(alpha.values.begin(), alpha.values.end(), 0.0);
}

TEST(Alternating, OneInvalidTexelGrowsToAFourByFourBlockWhereverItLies) {
  for (int y = 4; y < 12; ++y) {
    for (int x = 4; x < 12; ++x) {
      const AlphaImage grown = alternating_pass(with_hole(16, x, y));
      EXPECT_EQ(invalid_texels(grown), 16) << x << ", " << y;
      for (int v = y / 2 * 2 - 1; v < y / 2 * 2 + 3; ++v) {
        for (int u = x / 2 * 2 - 1; u < x / 2 * 2 + 3; ++u) EXPECT_EQ(grown.at(u, v), 0) << u << ", " << v;
      }
    }
  }
}

TEST(Alternating, ByHand) {
  EXPECT_EQ(rows(alternating_pass(image({"########",  //
                                         "########",  //
                                         "##.#####",  //
                                         "########",  //
                                         "######oo",  //
                                         "######oo"}))),
            (std::vector<std::string>{"########",  //
                                      "#....###",  //
                                      "#....###",  //
                                      "#....###",  //
                                      "#....#oo",  //
                                      "######oo"}));
}

TEST(Alternating, OddSizesAreRoundedUpAndTheBorderIsClamped) {
  EXPECT_EQ(rows(alternating_pass(image({"#####",  //
                                         "#####",  //
                                         "####."}))),
            (std::vector<std::string>{"#####",  //
                                      "###..",  //
                                      "###.."}));
  EXPECT_EQ(rows(alternating_pass(image({"."}))), std::vector<std::string>{"."});
  EXPECT_EQ(rows(alternating_pass(image({"#"}))), std::vector<std::string>{"#"});
}

TEST(Diamond, OneInvalidTexelGrowsByOneStepAPass) {
  AlphaImage alpha = with_hole(11, 5, 5);
  for (int pass = 1; pass <= 3; ++pass) {
    alpha = diamond_pass(alpha, 3.5);
    for (int y = 0; y < 11; ++y) {
      for (int x = 0; x < 11; ++x) {
        EXPECT_EQ(alpha.at(x, y), std::abs(x - 5) + std::abs(y - 5) <= pass ? 0 : 1) << x << ", " << y;
      }
    }
  }
}

TEST(Diamond, ThresholdsBetweenThreeAndThreeSevenEighthsActAlike) {
  const AlphaImage before = image({"ooooooooo",  //
                                   "oo#####oo",  //
                                   "oo###.#oo",  //
                                   "oo#####oo",  //
                                   "ooooooooo"});
  const std::vector<std::string> expected{"ooooooooo",  //
                                          "oo###.#oo",  //
                                          "oo##...oo",  //
                                          "oo###.#oo",  //
                                          "ooooooooo"};
  for (const double alpha_c : {3.0, 3.25, 3.5, 3.874}) EXPECT_EQ(rows(diamond_pass(before, alpha_c)), expected);
}

TEST(Diamond, BelowThreeNothingGrowsAndFromThreeSevenEighthsTheOutsideErodes) {
  EXPECT_EQ(diamond_pass(with_hole(5, 2, 2), 2.99).values, with_hole(5, 2, 2).values);
  const AlphaImage lone = image({"ooo",  //
                                 "o#o",  //
                                 "ooo"});
  EXPECT_EQ(diamond_pass(lone, 3.874).at(1, 1), 1);
  EXPECT_EQ(diamond_pass(lone, 3.875).at(1, 1), 0);
}

TEST(Suppression, TheOutsideNeverEatsIntoThePolygonAndKeepsItsAlpha) {
  AlphaImage alpha = image({"ooooooo",  //
                            "oo###oo",  //
                            "o#####o",  //
                            "oo#ooo#",  //
                            "ooooooo"});
  EXPECT_EQ(rows(diamond_pass(alpha, 3.5)), rows(alpha));
  EXPECT_EQ(rows(alternating_pass(alpha)), rows(alpha));
  for (int n = 1; n <= 4; ++n) EXPECT_EQ(rows(progressive(alpha, n)), rows(alpha));
}

TEST(Progressive, OnePassIsOneAlternatingPass) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    AlphaImage alpha(13, 10, 1.0);
    for (double& a : alpha.values) a = random() % 20 == 0 ? 0 : random() % 3 == 0 ? kOutside : 1;
    EXPECT_EQ(progressive(alpha, 1).values, alternating_pass(alpha).values);
  }
}

TEST(Progressive, ByHand) {
  // 16 -> 8 -> 4: texel 5 lies in 2 and then in 1. Back: 4 -> 8 kills 1..4, 8 -> 16 kills 1..10.
  AlphaImage alpha = full(16, 1);
  alpha.at(5, 0) = 0;
  EXPECT_EQ(rows(progressive(alpha, 2)), std::vector<std::string>{"#..........#####"});
}

TEST(Suppression, NothingIsEverRevivedAndMoreInvalidNeverGivesMoreValid) {
  std::mt19937 random(5);
  for (int round = 0; round < 30; ++round) {
    AlphaImage more(17, 9, 1.0);
    for (double& a : more.values) a = random() % 30 == 0 ? 0 : random() % 4 == 0 ? kOutside : 1;
    AlphaImage less = more;
    for (double& a : less.values) {
      if (random() % 20 == 0) a = 0;
    }
    const auto check = [&](const AlphaImage& from_more, const AlphaImage& from_less) {
      for (std::size_t i = 0; i < more.values.size(); ++i) {
        EXPECT_TRUE(from_more.values[i] == more.values[i] || from_more.values[i] == 0);
        EXPECT_LE(from_less.values[i], from_more.values[i]);
      }
    };
    check(diamond_pass(more, 3.5), diamond_pass(less, 3.5));
    check(alternating_pass(more), alternating_pass(less));
    check(progressive(more, 3), progressive(less, 3));
  }
}

}  // namespace
}  // namespace foreview::oracle
