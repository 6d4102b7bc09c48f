#include "oracle/hole_filling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

namespace foreview::oracle {
namespace {

using Row = std::vector<std::optional<double>>;
const std::nullopt_t kHole = std::nullopt;

/// Blue carries the value, green its double, red a constant.
glm::dvec3 colour(double value) {
  return {value, 2 * value, 7};
}

Texture texture(const std::vector<Row>& rows) {
  Texture result(static_cast<int>(rows[0].size()), static_cast<int>(rows.size()));
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      const auto& value = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
      result.valid.at(x, y) = value.has_value() ? 1 : 0;
      // What lies under a hole must not matter.
      result.colour.at(x, y) = value.has_value() ? colour(*value) : glm::dvec3(1e6);
    }
  }
  return result;
}

void expect_values(const ColourImage& image, const std::vector<std::vector<double>>& rows) {
  ASSERT_EQ(image.height, static_cast<int>(rows.size()));
  for (int y = 0; y < image.height; ++y) {
    ASSERT_EQ(image.width, static_cast<int>(rows[static_cast<std::size_t>(y)].size()));
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec3 expected = colour(rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(x, y)[c], expected[c], 1e-9) << x << ", " << y << ", " << c;
    }
  }
}

TEST(Fusion, NewWhereValidElseOldElseInvalid) {
  const Texture fused = fuse(texture({{1, 2, kHole, kHole}}), texture({{5, kHole, 6, kHole}}));
  EXPECT_EQ(fused.valid.values, (std::vector<unsigned char>{1, 1, 1, 0}));
  EXPECT_EQ(fused.colour.at(0, 0), colour(5));
  EXPECT_EQ(fused.colour.at(1, 0), colour(2));
  EXPECT_EQ(fused.colour.at(2, 0), colour(6));
}

TEST(Pyramid, PullAveragesTheValidChildrenOnly) {
  const Texture coarse = pull(texture({{1, 3, kHole, kHole},  //
                                       {5, 7, kHole, 9}}));
  EXPECT_EQ(coarse.valid.values, (std::vector<unsigned char>{1, 1}));
  expect_values(coarse.colour, {{4, 9}});
  EXPECT_EQ(pull(texture({{kHole, kHole}})).valid.values, (std::vector<unsigned char>{0}));
}

TEST(Pyramid, AnAxisOfOneTexelStaysWhileTheOtherIsHalved) {
  expect_values(pull(texture({{1, 3, 5, kHole}})).colour, {{2, 5}});
  const Texture column = pull(texture({{1}, {3}}));
  EXPECT_EQ(column.width(), 1);
  expect_values(column.colour, {{2}});
}

TEST(Pyramid, FillsByHand) {
  // Levels: {8, 16, -, -}; {12, -}; {12}. Back: {12, 12}; {8, 16, 12, 12}.
  expect_values(fill_by_pyramid(texture({{8, 16, kHole, kHole}})), {{8, 16, 12, 12}});
  // Levels: {8, -, -, 16}; {8, 16}; back: 3/4 of the nearer, 1/4 of the farther.
  expect_values(fill_by_pyramid(texture({{8, kHole, kHole, 16}})), {{8, 10, 14, 16}});
  // 4x4: the pulled 2x2 is {4, -; -, 20}, its top 12; pushed {4, 12; 12, 20}; then 9/16, 3/16, 3/16, 1/16.
  const ColourImage filled = fill_by_pyramid(texture({{4, kHole, kHole, kHole},  //
                                                      {kHole, kHole, kHole, kHole},
                                                      {kHole, kHole, kHole, kHole},
                                                      {kHole, kHole, kHole, 20}}));
  expect_values(filled, {{4, 6, 10, 12}, {6, 8, 12, 14}, {10, 12, 16, 18}, {12, 14, 18, 20}});
}

TEST(Pyramid, OneValidTexelFillsAll) {
  const ColourImage filled = fill_by_pyramid(texture({{kHole, kHole, kHole, kHole, kHole, kHole, kHole, kHole},
                                                      {kHole, kHole, kHole, 3, kHole, kHole, kHole, kHole}}));
  expect_values(filled, {{3, 3, 3, 3, 3, 3, 3, 3}, {3, 3, 3, 3, 3, 3, 3, 3}});
}

TEST(Filling, AConstantStaysAndNothingLeavesTheRangeOfWhatIsValid) {
  Texture holes(16, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) {
      holes.valid.at(x, y) = (x * 7 + y * 5) % 11 == 0 ? 1 : 0;
      holes.colour.at(x, y) = colour(x * 7.0);
    }
  }
  for (const ColourImage& filled : {fill_by_pyramid(holes), fill_iteratively(holes)}) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 16; ++x) {
        if (holes.valid.at(x, y) != 0) {
          EXPECT_EQ(filled.at(x, y), holes.colour.at(x, y));
        }
        EXPECT_GE(filled.at(x, y).x, 0);
        EXPECT_LE(filled.at(x, y).x, 105);
        EXPECT_NEAR(filled.at(x, y).z, 7, 1e-9);
      }
    }
  }
}

TEST(Iterative, GrowsInwardsFromTheRimByHand) {
  int passes = 0;
  // Pass 1 reaches one texel, but averages what lies within two.
  const ColourImage filled = fill_iteratively(texture({{4, 8, kHole, kHole, kHole, kHole}}), &passes);
  // x2 = (4 + 8) / 2; x3 = (8 + 6) / 2; x4 = (6 + 7) / 2; x5 = (7 + 6.5) / 2.
  expect_values(filled, {{4, 8, 6, 7, 6.5, 6.75}});
  EXPECT_EQ(passes, 4);
}

TEST(Iterative, PassesReadOnlyThePassBefore) {
  int passes = 0;
  // Both holes are filled in one pass from the valid texels alone: were the left one used for the right one, the right
  // one would be (6 + 12) / 2 = 9.
  expect_values(fill_iteratively(texture({{0, kHole, kHole, 12}}), &passes), {{0, 6, 6, 12}});
  EXPECT_EQ(passes, 1);
  expect_values(fill_iteratively(texture({{0, kHole, kHole, kHole, 12}}), &passes), {{0, 0, 6, 12, 12}});
  EXPECT_EQ(passes, 2);
}

TEST(Filling, WithNothingValidIsMidGrey) {
  const Texture empty = texture({{kHole, kHole}, {kHole, kHole}});
  int passes = -1;
  for (const ColourImage& filled :
       {fill_by_pyramid(empty), fill_iteratively(empty, &passes), leave_holes_grey(empty)}) {
    for (const glm::dvec3& value : filled.values) EXPECT_EQ(value, glm::dvec3(128));
  }
  EXPECT_EQ(passes, 0);
  EXPECT_EQ(leave_holes_grey(texture({{1, kHole}})).at(0, 0), colour(1));
}

TEST(Filling, HolesLeftOpenAreGreyOnlyInThePolygon) {
  Flags in_polygon(4, 1, 1);
  in_polygon.at(3, 0) = 0;
  const ColourImage filled = leave_holes_open(texture({{8, 16, kHole, kHole}}), in_polygon);
  EXPECT_EQ(filled.at(0, 0), colour(8));
  EXPECT_EQ(filled.at(1, 0), colour(16));
  EXPECT_EQ(filled.at(2, 0), glm::dvec3(128));
  EXPECT_EQ(filled.at(3, 0), colour(12)) << "as the pyramid fills it";
}

}  // namespace
}  // namespace foreview::oracle
