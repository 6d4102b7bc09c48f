#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "oracle/batched_extraction.h"
#include "oracle/test_scenes.h"

namespace foreview::oracle {
namespace {

constexpr double kNear = 0.1;

std::size_t open_pairs(const Image<Surface>& s) {
  std::size_t count = 0;
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      if (x + 1 < s.width && is_open(s.at(x, y), s.at(x + 1, y), 1, 0)) ++count;
      if (y + 1 < s.height && is_open(s.at(x, y), s.at(x, y + 1), 0, 1)) ++count;
    }
  }
  return count;
}

std::size_t pixels_of(const Image<Surface>& s, int polygon) {
  return static_cast<std::size_t>(
      std::count_if(s.values.begin(), s.values.end(), [&](const Surface& v) { return v.polygon == polygon; }));
}

/// Two walls that fill the picture and meet in an upright edge at x = 0.013, `depth` metres away; their far sides are
/// at depth + `bend`.
Image<Surface> crease(const CameraModel& camera, double depth, double bend) {
  const double x = 0.013, half = 8, tall = 8;
  const PolygonModel model = model_of(
      {{{x - half, -tall, depth + bend}, {x - half, tall, depth + bend}, {x, tall, depth}, {x, -tall, depth}},
       {{x, -tall, depth}, {x, tall, depth}, {x + half, tall, depth + bend}, {x + half, -tall, depth + bend}}});
  return surfaces(model, camera, at_origin(model), kNear);
}

TEST(BatchedSurfaces, AreThePlanesAtPixelCentresWithTheirSlopes) {
  const CameraModel camera = pinhole(40, 30, 40);
  const PolygonModel model = model_of({{{-3, -3, 2}, {-3, 3, 2}, {3, 3, 6}, {3, -3, 6}}});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  const Surface& p = s.at(23, 11);
  ASSERT_EQ(p.polygon, 0);
  // The plane is z = 4 + 2/3 x: 1/z = (1 - 2/3 X) / 4 with X = (u - 20) / 40.
  EXPECT_NEAR(p.w, (1 - 2.0 / 3 * 3.5 / 40) / 4, 1e-12);
  EXPECT_NEAR(p.a, -2.0 / 3 / 40 / 4, 1e-12);
  EXPECT_NEAR(p.b, 0, 1e-12);
  EXPECT_NEAR(p.range.least, 1.0 / 6, 1e-12);
  EXPECT_NEAR(p.range.greatest, 1.0 / 2, 1e-12);
  EXPECT_NEAR(p.continued(-2, 7), p.w - 2 * p.a, 1e-12);
  EXPECT_NEAR(p.continued(-2000, 0), 1.0 / 2, 1e-12) << "kept within the range of its corners";
  EXPECT_EQ(s.at(0, 0).polygon, 0);
}

TEST(BatchedSurfaces, CornersBeforeTheNearPlaneCountAsLyingOnIt) {
  const CameraModel camera = pinhole(100, 80, 100);
  const PolygonModel model = model_of({{{-1, 0.3, -2}, {-1, 0.3, 4}, {1, 0.3, 4}, {1, 0.3, -2}}});
  const PictureSurface floor = picture_surface(model, 0, camera, at_origin(model), kNear);
  EXPECT_NEAR(floor.range.greatest, 10, 1e-12);
  EXPECT_NEAR(floor.range.least, 0.25, 1e-12);
}

TEST(BatchedContours, AConcaveAndAConvexCreaseAreNone) {
  const CameraModel camera = pinhole(60, 50, 60);
  for (const double bend : {-1.5, -0.4, 0.3, 1.5, 6.0}) {
    const Image<Surface> s = crease(camera, 2, bend);
    ASSERT_GT(pixels_of(s, 0), 500u);
    ASSERT_GT(pixels_of(s, 1), 500u);
    EXPECT_EQ(open_pairs(s), 0u) << bend;
  }
}

TEST(BatchedContours, ASilhouetteIsOneAndItsRimIsTheNearerPixel) {
  const CameraModel camera = pinhole(40, 30, 40);
  // The chip covers x 16..23, y 11..18 before a wall that fills the picture.
  const PolygonModel model = model_of({facing_rectangle(-3, -3, 3, 3, 4), facing_rectangle(-0.2, -0.2, 0.2, 0.2, 2)});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  ASSERT_EQ(pixels_of(s, 1), 64u);
  EXPECT_EQ(open_pairs(s), 32u);
  EXPECT_TRUE(is_open(s.at(15, 15), s.at(16, 15), 1, 0));
  EXPECT_TRUE(is_open(s.at(16, 15), s.at(15, 15), -1, 0));
  EXPECT_TRUE(is_open(s.at(20, 18), s.at(20, 19), 0, 1));
  EXPECT_FALSE(is_open(s.at(16, 15), s.at(17, 15), 1, 0));
  const AlphaImage r = rims(s);
  EXPECT_EQ(std::count(r.values.begin(), r.values.end(), 0.5), 28) << "the chip's outermost pixels";
  EXPECT_EQ(std::count(r.values.begin(), r.values.end(), 0.0), 40 * 30 - 28) << "and no other";
  EXPECT_EQ(r.at(16, 11), 0.5);
}

TEST(BatchedContours, ASilhouetteBeforeNothingIsOneAndNothingBesideNothingIsNot) {
  const CameraModel camera = pinhole(40, 30, 40);
  const PolygonModel model = model_of({facing_rectangle(-0.2, -0.2, 0.2, 0.2, 2)});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  EXPECT_EQ(open_pairs(s), 32u);
}

/// A box of 0.4 m x 0.4 m on a table at z = 1 + height, its top at z = 1, seen straight from above: its sides are not
/// to be seen at all.
TEST(BatchedContours, AFlatBoxIsNoneUntilItsHeightIsAHundredth) {
  const CameraModel camera = pinhole(60, 50, 60);
  for (const double height : {0.005, 0.03}) {
    const PolygonModel model =
        model_of({facing_rectangle(-2, -2, 2, 2, 1 + height), facing_rectangle(-0.21, -0.21, 0.21, 0.21, 1)});
    const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
    ASSERT_GT(pixels_of(s, 1), 400u);
    EXPECT_EQ(open_pairs(s) > 0, height > 0.01) << height;
  }
}

/// A box 0.3 m high on a table; the camera looks down at it aslant, so that one side shows. From the top over the side
/// to the table surfaces meet; behind the box they do not.
TEST(BatchedContours, ASideThatShowsConnectsTheTopWithTheTable) {
  const CameraModel camera = pinhole(80, 60, 80);
  // y down. The table is y = 0.5, the box's top y = 0.2, from z = 1.5 to z = 1.9.
  const double table = 0.5, top = 0.2, front = 1.5, back = 1.9, half = 3;
  const PolygonModel model = model_of({{{-half, table, 0.2}, {half, table, 0.2}, {half, table, 6}, {-half, table, 6}},
                                       {{-half, top, front}, {half, top, front}, {half, top, back}, {-half, top, back}},
                                       facing_rectangle(-half, top, half, table, front)});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  const int x = 40;
  int behind = 0;
  for (int y = 0; y + 1 < camera.height; ++y) {
    const Surface &p = s.at(x, y), &q = s.at(x, y + 1);
    if (p.polygon == q.polygon) {
      EXPECT_FALSE(is_open(p, q, 0, 1)) << y;
    } else if (p.polygon == 0 && q.polygon == 1) {
      EXPECT_TRUE(is_open(p, q, 0, 1)) << "the table behind the box, " << y;
      ++behind;
    } else if (p.polygon >= 0) {
      EXPECT_FALSE(is_open(p, q, 0, 1)) << "polygons " << p.polygon << " and " << q.polygon << ", " << y;
    }
  }
  EXPECT_EQ(behind, 1);
  EXPECT_GT(pixels_of(s, 2), 500u);
}

/// A side seen so nearly edge-on that it is one pixel wide, and 0.3 m deep within it: its slope says nothing there, but
/// its range does.
TEST(BatchedContours, ASideSeenEdgeOnConnectsWhatItLiesBetween) {
  const CameraModel camera = pinhole(60, 50, 60);
  // Columns: top (z = 1) up to u = 40.2, side up to u = 41.1, table (z = 1.3) from there.
  const double x0 = 10.2 / 60, x1 = 11.1 / 60 * 1.3;
  const PolygonModel model = model_of({facing_rectangle(-2, -2, x0, 2, 1),
                                       {{x0, -2, 1}, {x0, 2, 1}, {x1, 2, 1.3}, {x1, -2, 1.3}},
                                       facing_rectangle(x1, -2, 3, 2, 1.3)});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  ASSERT_EQ(s.at(39, 20).polygon, 0);
  ASSERT_EQ(s.at(40, 20).polygon, 1);
  ASSERT_EQ(s.at(41, 20).polygon, 2);
  ASSERT_GT(std::abs(s.at(40, 20).a), 0.1) << "steep";
  EXPECT_EQ(open_pairs(s), 0u);
  // Without the side there is a step.
  const PolygonModel without =
      model_of({facing_rectangle(-2, -2, x0, 2, 1), facing_rectangle(x1 - 0.1, -2, 3, 2, 1.3)});
  EXPECT_GT(open_pairs(surfaces(without, camera, at_origin(without), kNear)), 0u);
}

TEST(BatchedSuppression, SpreadsInDiamondsAndTheNearestWins) {
  AlphaImage r(11, 9, 0.0);
  r.at(3, 4) = 0.5;
  r.at(7, 4) = 2;
  const AlphaImage none = spread(r, 0);
  EXPECT_EQ(none.values, r.values);
  const AlphaImage two = spread(r, 2);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 11; ++x) {
      const bool in_far = std::abs(x - 3) + std::abs(y - 4) <= 2, in_near = std::abs(x - 7) + std::abs(y - 4) <= 2;
      EXPECT_EQ(two.at(x, y), in_near ? 2 : in_far ? 0.5 : 0) << x << ", " << y;
    }
  }
}

TEST(BatchedCells, HoldWhatTheSurfacesReachWithinThem) {
  const CameraModel camera = pinhole(40, 30, 40);
  const PolygonModel model = model_of({{{-3, -3, 2}, {-3, 3, 2}, {3, 3, 6}, {3, -3, 6}}});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  const Flags usable(40, 30, 1);
  const Image<Cell> c = cells(s, nullptr, usable);
  ASSERT_EQ(c.width, 39);
  ASSERT_EQ(c.height, 29);
  // At the cell's middle, u = 24: 1/z = (1 - 2/3 * 4 / 40) / 4; half a pixel to either side 1/480.
  const double middle = (1 - 2.0 / 3 * 4 / 40) / 4, half = 2.0 / 3 / 40 / 4 / 2;
  EXPECT_NEAR(c.at(23, 11).least, (middle - half) * 0.999, 1e-12);
  EXPECT_NEAR(c.at(23, 11).greatest, (middle + half) * 1.001, 1e-12);
  // With something unsafe at one of its pixels, nothing behind that.
  AlphaImage unsafe(40, 30, 0.0);
  unsafe.at(24, 12) = middle / 0.99;
  EXPECT_NEAR(cells(s, &unsafe, usable).at(23, 11).least, middle, 1e-12);
  unsafe.at(24, 12) = 0.26;
  const Image<Cell> suppressed = cells(s, &unsafe, usable);
  EXPECT_TRUE(suppressed.at(23, 11).takes_nothing(false));
  EXPECT_FALSE(suppressed.at(23, 11).takes_nothing(true)) << "thin polygons are not suppressed";
  EXPECT_NEAR(suppressed.at(23, 11).least, c.at(23, 11).least, 1e-12);
  EXPECT_NEAR(suppressed.at(22, 11).least, c.at(22, 11).least, 1e-12);
  unsafe.at(24, 12) = 0.2;
  EXPECT_NEAR(cells(s, &unsafe, usable).at(23, 11).least, c.at(23, 11).least, 1e-12) << "behind the surface itself";
}

TEST(BatchedCells, TakeNothingAcrossAContourOrWhereAPixelIsUnusable) {
  const CameraModel camera = pinhole(40, 30, 40);
  const PolygonModel model = model_of({facing_rectangle(-3, -3, 3, 3, 4), facing_rectangle(-0.2, -0.2, 0.2, 0.2, 2)});
  const Image<Surface> s = surfaces(model, camera, at_origin(model), kNear);
  Flags usable(40, 30, 1);
  usable.at(5, 6) = 0;
  const Image<Cell> c = cells(s, nullptr, usable);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      // The chip is x 16..23, y 11..18: cells 15 and 23 along x, 10 and 18 along y lie across its outline.
      const bool beside = x >= 15 && x <= 23 && y >= 10 && y <= 18;
      const bool within = x >= 16 && x <= 22 && y >= 11 && y <= 17;
      const bool unusable = (x == 4 || x == 5) && (y == 5 || y == 6);
      EXPECT_EQ(c.at(x, y).takes_nothing(false), (beside && !within) || unusable) << x << ", " << y;
      EXPECT_EQ(c.at(x, y).takes_nothing(true), unusable) << x << ", " << y;
      if (unusable) continue;
      EXPECT_LT(c.at(x, y).least, within ? 0.5 : 0.25) << x << ", " << y;
      EXPECT_GT(c.at(x, y).greatest, beside ? 0.5 : 0.25) << x << ", " << y;
    }
  }
}

/// Charts of a model, one polygon each, seen by a camera at the origin; the picture's colours tell the position.
struct Extracted {
  CameraModel camera;
  PolygonModel model;
  ChartLayout layout;
  BatchedOptions options;
  CameraFrame frame;
  Extracted(const CameraModel& camera_, PolygonModel model_, double density, int passes)
      : camera(camera_), model(std::move(model_)) {
    ChartOptions charts;
    charts.texels_per_metre = density;
    charts.page_size = 1024;
    charts.group_polygons = false;
    layout = lay_out_charts(model, charts);
    options.passes = passes;
    options.near_plane = kNear;
    frame.camera = camera;
    frame.state = at_origin(model);
    frame.state.stamp = Timestamp{1'000'000};
    frame.picture = cv::Mat(camera.height, camera.width, CV_8UC3);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        frame.picture.at<cv::Vec3b>(y, x) =
            cv::Vec3b(static_cast<unsigned char>(3 * x), static_cast<unsigned char>(4 * y), 200);
      }
    }
  }
  [[nodiscard]] BatchedExtractionOracle::Gathered gathered(std::size_t polygon) const {
    const BatchedExtractionOracle oracle(model, layout, options);
    const BatchedPicture picture = oracle.look(frame);
    return oracle.gather_group(layout.charts[polygon].group, frame, picture.picture.colour, picture.cells);
  }
};

TEST(BatchedGather, TexelsTakeThePictureAtTheirPoint) {
  const Extracted e(pinhole(60, 50, 60), model_of({{{-0.5, -0.4, 2}, {-0.5, 0.4, 2}, {0.5, 0.4, 3}, {0.5, -0.4, 3}}}),
                    40, 3);
  const auto g = e.gathered(0);
  int inside = 0;
  for (int y = 0; y < g.texels.height; ++y) {
    for (int x = 0; x < g.texels.width; ++x) {
      const TexelOwner& owner = g.owners.at(x, y);
      const GatheredTexel& t = g.texels.at(x, y);
      EXPECT_EQ(owner.polygon < 0 && t.taken, false);
      if (!owner.inside) continue;
      const Chart& chart = e.layout.charts[0];
      const glm::dvec3 p = chart.part_from_texel(glm::dvec2(chart.origin) + glm::dvec2(x + 0.5, y + 0.5));
      ++inside;
      EXPECT_NEAR(t.pixel.x, 30 + 60 * p.x / p.z, 1e-9);
      EXPECT_NEAR(t.w, 1 / p.z, 1e-9);
      if (!t.taken) continue;
      EXPECT_NEAR(t.colour.x, 3 * (t.pixel.x - 0.5), 1e-9);
      EXPECT_NEAR(t.colour.y, 4 * (t.pixel.y - 0.5), 1e-9);
    }
  }
  EXPECT_NEAR(inside, 32 * 40 * std::sqrt(2.0), 120);
  EXPECT_GT(std::count_if(g.texels.values.begin(), g.texels.values.end(), [](const auto& t) { return t.taken; }),
            inside / 2);
}

/// A wall 4 m away with a chip 2 m away before it, which covers pixels x 16..23, y 11..18.
Extracted wall_and_chip(int passes) {
  return {pinhole(40, 30, 40),
          model_of({facing_rectangle(-1.8, -1.3, 1.8, 1.3, 4), facing_rectangle(-0.2, -0.2, 0.2, 0.2, 2)}), 26, passes};
}

TEST(BatchedGather, ThinPolygonsTakeColoursBesideContours) {
  struct Case {
    const char* what;
    double width, height, z;  // metres
    bool thin, taken;
  };
  // Beside the chip of 2 m, whose right edge projects to u = 24: with 40 pixels of focal length, 0.05 m there are one.
  // Half a pixel wide, a strip lies between the centres of two columns of pixels, which show chip and wall.
  for (const Case& c :
       {Case{"half a pixel", 0.02, 0.2, 2, true, true}, Case{"a pixel, behind the rim", 0.08, 0.2, 2.5, false, false},
        Case{"behind the chip's rim, before the wall", 0.02, 0.2, 2.5, true, true},
        Case{"behind the wall", 0.04, 0.3, 4.5, true, false}}) {
    const double left = (24.03 - 20) / 40 * c.z, top = -c.height / 2;
    const Extracted e{pinhole(40, 30, 40),
                      model_of({facing_rectangle(-1.8, -1.3, 1.8, 1.3, 4), facing_rectangle(-0.2, -0.2, 0.2, 0.2, 2),
                                facing_rectangle(left, top, left + c.width, top + c.height, c.z)}),
                      150, 3};
    EXPECT_EQ(picture_surface(e.model, 2, e.camera, e.frame.state, kNear).thin, c.thin) << c.what;
    const auto strip = e.gathered(2);
    int inside = 0, taken = 0;
    for (std::size_t i = 0; i < strip.texels.values.size(); ++i) {
      if (!strip.owners.values[i].inside) continue;
      ++inside;
      taken += strip.texels.values[i].taken ? 1 : 0;
    }
    ASSERT_GT(inside, 20) << c.what;
    EXPECT_EQ(taken, c.taken ? inside : 0) << c.what;
  }
  // Seen edge-on: thin, but long.
  const PolygonModel edge_on = model_of({{{-1, 0.001, 2}, {1, 0.001, 2}, {1, 0.002, 4}, {-1, 0.002, 4}}});
  const CameraModel camera = pinhole(40, 30, 40);
  EXPECT_FALSE(picture_surface(edge_on, 0, camera, at_origin(edge_on), kNear).thin);
}

TEST(BatchedGather, RefusesWhatLiesBehindARimAndNotTheOccluder) {
  for (const int passes : {0, 1, 3}) {
    const Extracted e = wall_and_chip(passes);
    const auto wall = e.gathered(0), chip = e.gathered(1);
    int refused = 0, taken = 0, beside = 0;
    for (std::size_t i = 0; i < wall.texels.values.size(); ++i) {
      if (!wall.owners.values[i].inside) continue;
      const GatheredTexel& t = wall.texels.values[i];
      // The wall's own outermost pixels lie beside a contour, too.
      if (std::abs(t.pixel.x - 20) > 17.5 || std::abs(t.pixel.y - 15) > 12.5) continue;
      // How far beyond the chip's outermost pixel centres, in pixels.
      const double dx = std::max({16.5 - t.pixel.x, t.pixel.x - 23.5, 0.0});
      const double dy = std::max({11.5 - t.pixel.y, t.pixel.y - 18.5, 0.0});
      if (dx == 0 && dy == 0) {
        EXPECT_FALSE(t.taken) << "behind the chip";
        ++refused;
      } else if (dy == 0) {
        if (std::abs(dx - std::round(dx)) < 1e-9) continue;  // on a pixel's centre: between two cells
        // Cells take nothing if one of their pixels is within `passes` of the rim, and the one at the contour never.
        const bool expected = dx > passes + 1;
        EXPECT_EQ(t.taken, expected) << passes << " passes, " << dx << " pixels beside";
        ++beside;
      } else if (dx + dy > passes + 2) {
        EXPECT_TRUE(t.taken);
        ++taken;
      }
    }
    EXPECT_GT(refused, 100);
    EXPECT_GT(beside, 100);
    EXPECT_GT(taken, 100);
    int own = 0;
    for (std::size_t i = 0; i < chip.texels.values.size(); ++i) {
      if (!chip.owners.values[i].inside) continue;
      const GatheredTexel& t = chip.texels.values[i];
      const bool within = t.pixel.x > 16.5 && t.pixel.x < 23.5 && t.pixel.y > 11.5 && t.pixel.y < 18.5;
      EXPECT_EQ(t.taken, within) << "the chip's own texels, up to the pixels that are its own";
      ++own;
    }
    EXPECT_GE(own, 81);
  }
}

TEST(BatchedGather, GutterBeyondASilhouetteTakesNothing) {
  const auto chip = wall_and_chip(3).gathered(1);
  int gutter = 0;
  for (std::size_t i = 0; i < chip.texels.values.size(); ++i) {
    if (chip.owners.values[i].polygon < 0 || chip.owners.values[i].inside) continue;
    ++gutter;
    EXPECT_TRUE(chip.texels.values[i].in_picture);
    EXPECT_FALSE(chip.texels.values[i].taken);
  }
  EXPECT_GE(gutter, 2 * 4 * 8);
}

TEST(BatchedGather, GutterTakesTheNeighboursColoursWhereTheSurfaceGoesOn) {
  // Two halves of a wall that is slightly bent between them.
  const Extracted e(pinhole(40, 30, 40),
                    model_of({facing_rectangle(-0.8, -0.6, 0.01, 0.6, 2),
                              {{0.01, -0.6, 2}, {0.01, 0.6, 2}, {0.8, 0.6, 2.1}, {0.8, -0.6, 2.1}}}),
                    40, 3);
  const auto left = e.gathered(0);
  int beyond = 0;
  for (std::size_t i = 0; i < left.texels.values.size(); ++i) {
    const TexelOwner& owner = left.owners.values[i];
    const GatheredTexel& t = left.texels.values[i];
    if (owner.polygon < 0 || owner.inside || t.pixel.x < 20.2 || t.pixel.y < 4.5 || t.pixel.y > 25.5) continue;
    EXPECT_TRUE(t.taken) << t.pixel.x << ", " << t.pixel.y;
    ++beyond;
  }
  EXPECT_GE(beyond, 2 * 40);
}

TEST(BatchedGather, GutterSurroundsTheOutlineAndOwnTexelsWin) {
  const Extracted e(pinhole(40, 30, 40), model_of({facing_rectangle(-0.5, -0.25, 0.5, 0.25, 2)}), 20, 0);
  const Image<TexelOwner> owners = texel_owners(e.model, e.layout, 0, {true});
  int inside = 0, gutter = 0;
  for (const TexelOwner& owner : owners.values) {
    if (owner.inside) ++inside;
    if (owner.polygon >= 0 && !owner.inside) ++gutter;
  }
  EXPECT_EQ(inside, 20 * 10);
  // Two rows and columns about it, and at each corner the three texels whose centres are within 2 of it.
  EXPECT_EQ(gutter, 2 * 2 * (20 + 10) + 4 * 3);
  const Image<TexelOwner> back = texel_owners(e.model, e.layout, 0, {false});
  EXPECT_EQ(std::count_if(back.values.begin(), back.values.end(), [](const auto& o) { return o.polygon >= 0; }), 200);
}

TEST(BatchedGather, BackFacesTakeNothing) {
  auto back = facing_rectangle(-0.5, -0.4, 0.5, 0.4, 2);
  std::swap(back[1], back[3]);
  const Extracted e(pinhole(40, 30, 40), model_of({back}), 40, 3);
  for (const GatheredTexel& t : e.gathered(0).texels.values) EXPECT_FALSE(t.taken || t.in_picture);
}

TEST(BatchedGather, ANearPolygonIsSampledMoreOften) {
  // 4 texels a metre at 5 m, focal length 60: 3 pixels a texel.
  Extracted e(pinhole(60, 50, 60), model_of({facing_rectangle(-2, -1.5, 2, 1.5, 5)}), 4, 0);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 60; ++x) {
      // Alternate columns: one sample sees anything between them, three see their mean, the middle one counted once.
      e.frame.picture.at<cv::Vec3b>(y, x) = x % 2 == 0 ? cv::Vec3b(0, 0, 0) : cv::Vec3b(90, 90, 90);
    }
  }
  const auto g = e.gathered(0);
  const auto triangle = [](double u) {  // the picture between its columns
    const double phase = std::fmod(u - 0.5, 2);
    return 90 * (phase < 1 ? phase : 2 - phase);
  };
  int taken = 0;
  for (const GatheredTexel& t : g.texels.values) {
    if (!t.taken) continue;
    EXPECT_NEAR(t.step, 3, 1e-9);
    const double expected = (triangle(t.pixel.x - 1) + triangle(t.pixel.x) + triangle(t.pixel.x + 1)) / 3;
    EXPECT_NEAR(t.colour.x, expected, 1e-9);
    ++taken;
  }
  EXPECT_GT(taken, 100);
}

TEST(BatchedFusion, NewestWinsAndALatePictureOnlyFills) {
  const Extracted e(pinhole(40, 30, 40), model_of({facing_rectangle(-0.5, -0.25, 0.5, 0.25, 2)}), 20, 0);
  BatchedExtractionOracle oracle(e.model, e.layout, e.options);
  const ChartGroup& block = e.layout.groups[0];
  const auto picture = [&](const std::vector<int>& columns, double grey) {
    BatchedExtractionOracle::Gathered g;
    g.shown = true;
    g.texels = Image<GatheredTexel>(block.size.x, block.size.y);
    for (const int x : columns) {
      g.texels.at(x, 0).taken = true;
      g.texels.at(x, 0).colour = glm::dvec3(grey);
    }
    return g;
  };
  const auto expect = [&](const std::vector<double>& greys) {
    for (std::size_t x = 0; x < greys.size(); ++x) {
      const auto i = static_cast<int>(x);
      EXPECT_EQ(oracle.observed(0).valid.at(i, 0) != 0, greys[x] > 0) << x;
      if (greys[x] > 0) {
        EXPECT_EQ(oracle.observed(0).colour.at(i, 0).x, greys[x]) << x;
      }
    }
  };
  EXPECT_FALSE(BatchedExtractionOracle::any_observed(oracle.observed(0)));
  oracle.fuse_group(0, Timestamp{20}, picture({0, 1}, 50));
  expect({50, 50, 0, 0});
  oracle.fuse_group(0, Timestamp{30}, picture({1, 2}, 60));
  expect({50, 60, 60, 0});
  oracle.fuse_group(0, Timestamp{10}, picture({0, 1, 2, 3}, 70));
  expect({50, 60, 60, 70});
  oracle.fuse_group(0, Timestamp{25}, picture({3}, 80));
  expect({50, 60, 60, 70});
  oracle.fuse_group(0, Timestamp{30}, picture({3}, 90));
  expect({50, 60, 60, 90});
  EXPECT_TRUE(BatchedExtractionOracle::any_observed(oracle.observed(0)));
  // A newer picture in which something hides all of the chart makes the next one late, one that looks away does not.
  auto nothing = picture({}, 0);
  nothing.shown = false;
  oracle.fuse_group(0, Timestamp{50}, nothing);
  EXPECT_FALSE(oracle.is_late(0, Timestamp{40}));
  oracle.fuse_group(0, Timestamp{50}, picture({}, 0));
  EXPECT_TRUE(oracle.is_late(0, Timestamp{40}));
}

TEST(BatchedPull, WeighsByWhatWasObserved) {
  Texture base(4, 2);
  const auto set = [&](int x, int y, double grey) {
    base.valid.at(x, y) = 1;
    base.colour.at(x, y) = glm::dvec3(grey);
  };
  set(0, 0, 10), set(1, 0, 30), set(0, 1, 50), set(1, 1, 70), set(3, 1, 100);
  const std::vector<ShareLevel> levels = levels_from(level_of(base));
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(levels[1].share.values, (std::vector<double>{1, 0.25}));
  EXPECT_NEAR(levels[1].colour.at(0, 0).x, 40, 1e-12);
  EXPECT_NEAR(levels[1].colour.at(1, 0).x, 100, 1e-12);
  EXPECT_NEAR(levels[2].colour.at(0, 0).x, (4 * 40 + 100) / 5.0, 1e-12) << "five texels, each counts once";
  EXPECT_NEAR(levels[2].share.at(0, 0), 0.625, 1e-12);
}

TEST(BatchedPull, OddSizesAreRoundedUpAndWhatLiesBeyondDoesNotCount) {
  ShareLevel level(5, 3);
  for (double& share : level.share.values) share = 1;
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 3; ++y) level.colour.at(x, y) = glm::dvec3(10 * x + y);
  }
  const ShareLevel up = pull_by_share(level);
  ASSERT_EQ(up.width(), 3);
  ASSERT_EQ(up.height(), 2);
  for (const double share : up.share.values) EXPECT_NEAR(share, 1, 1e-12);
  EXPECT_NEAR(up.colour.at(2, 1).x, 42, 1e-12);
  EXPECT_NEAR(up.colour.at(2, 0).x, 40.5, 1e-12);
}

TEST(BatchedPull, LittleIsNeverNothing) {
  Texture base(64, 64);
  base.valid.at(17, 40) = 1;
  base.colour.at(17, 40) = {9, 8, 7};
  const std::vector<ShareLevel> levels = levels_from(level_of(base));
  ASSERT_EQ(levels.size(), 7u);
  EXPECT_NEAR(levels[2].share.at(4, 10), 1.0 / 16, 1e-12);
  EXPECT_NEAR(levels[3].share.at(2, 5), 1.0 / 64, 1e-12);
  EXPECT_NEAR(levels[4].share.at(1, 2), 1.0 / 255, 1e-12);
  EXPECT_NEAR(levels[6].share.at(0, 0), 1.0 / 255, 1e-12);
  EXPECT_EQ(levels[6].colour.at(0, 0), glm::dvec3(9, 8, 7));
}

TEST(BatchedPush, WeighsEachLevelByTwiceItsShareAndKeepsWhatIsObserved) {
  // Two rows of four. Level 1: {12 (all), 30 (a quarter)}; tip: (4 * 12 + 30) / 5 = 15.6.
  // Down: F_1 = {12, 0.5 * 30 + 0.5 * 15.6 = 22.8}; a hole beside the left half is 1/4 of 12 and 3/4
  // of 22.8, one at the right end is 22.8: the enlarging stops at the block.
  Texture base(4, 2);
  const auto set = [&](int x, int y, double grey) {
    base.valid.at(x, y) = 1;
    base.colour.at(x, y) = glm::dvec3(grey);
  };
  set(0, 0, 10), set(1, 0, 14), set(0, 1, 11), set(1, 1, 13), set(2, 0, 30);
  const std::vector<ColourImage> f = shown_levels(levels_from(level_of(base)), 4, nullptr);
  ASSERT_EQ(f.size(), 3u);
  const double tip = 15.6, second = 22.8;
  EXPECT_NEAR(f[2].at(0, 0).x, tip, 1e-12);
  EXPECT_NEAR(f[1].at(0, 0).x, 12, 1e-12);
  EXPECT_NEAR(f[1].at(1, 0).x, second, 1e-12);
  EXPECT_EQ(f[0].at(0, 0).x, 10);
  EXPECT_EQ(f[0].at(2, 0).x, 30);
  EXPECT_NEAR(f[0].at(2, 1).x, 0.25 * 12 + 0.75 * second, 1e-12);
  EXPECT_NEAR(f[0].at(3, 1).x, second, 1e-12);
  set(3, 1, 50);  // half of it observed: nothing comes from above
  EXPECT_NEAR(shown_levels(levels_from(level_of(base)), 4, nullptr)[1].at(1, 0).x, 40, 1e-12);
}

TEST(BatchedPush, EnlargesWithinTheBlock) {
  ColourImage coarse(3, 1);
  for (int x = 0; x < 3; ++x) coarse.at(x, 0) = glm::dvec3(8 * x);
  const ColourImage fine = enlarge(coarse, 5, 2);
  const std::vector<double> expected{0, 2, 6, 10, 14};
  for (int x = 0; x < 5; ++x) {
    EXPECT_NEAR(fine.at(x, 0).x, expected[static_cast<std::size_t>(x)], 1e-12);
    EXPECT_NEAR(fine.at(x, 1).x, expected[static_cast<std::size_t>(x)], 1e-12);
  }
}

TEST(BatchedPush, LevelFourStaysUnlessItChanged) {
  FourthLevel before{ColourImage(4, 1), AlphaImage(4, 1, 0.5)}, fresh = before;
  before.colour.at(0, 0) = {100, 100, 100}, fresh.colour.at(0, 0) = {101, 99, 101.4};
  before.colour.at(1, 0) = {100, 100, 100}, fresh.colour.at(1, 0) = {100, 98.4, 100};
  before.colour.at(2, 0) = {0, 0, 0}, fresh.colour.at(2, 0) = {200, 0, 0};
  before.colour.at(3, 0) = {100, 100, 100}, fresh.colour.at(3, 0) = {101, 99, 101.4};
  fresh.share.at(3, 0) = 0.6;
  const ColourImage result = renewed(before, fresh);
  EXPECT_EQ(result.at(0, 0), before.colour.at(0, 0));
  EXPECT_EQ(result.at(1, 0), fresh.colour.at(1, 0));
  EXPECT_EQ(result.at(2, 0), fresh.colour.at(2, 0));
  EXPECT_EQ(result.at(3, 0), fresh.colour.at(3, 0)) << "more of it is observed";
}

}  // namespace
}  // namespace foreview::oracle
