#include "oracle/occlusion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "oracle/test_scenes.h"

namespace foreview::oracle {
namespace {

constexpr double kNear = 0.02;

UndistortedPicture plain_picture(const CameraModel& camera) {
  return undistort(cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar(1, 2, 3)), camera);
}

TEST(Projection, BoxIsInWholePixelsGrownByThreeAndCutToThePicture) {
  const CameraModel camera = pinhole(100, 80, 100);
  // At z = 2 a metre is 50 pixels: x from 50 - 12.5 to 50 + 20, y from 40 - 5 to 40 + 50 (cut at 80).
  const PolygonModel model = model_of({facing_rectangle(-0.25, -0.1, 0.4, 1.0, 2)});
  const ProjectedPolygon p = project(model, 0, camera, at_origin(model), kNear);
  EXPECT_TRUE(p.front());
  EXPECT_EQ(p.box.left, 37);
  EXPECT_EQ(p.box.top, 35);
  EXPECT_EQ(p.box.right, 70);
  EXPECT_EQ(p.box.bottom, 80);
  EXPECT_EQ(p.grown_box.left, 34);
  EXPECT_EQ(p.grown_box.top, 32);
  EXPECT_EQ(p.grown_box.right, 73);
  EXPECT_EQ(p.grown_box.bottom, 80);
  EXPECT_NEAR(p.area, 32.5 * 55, 1e-9);
  EXPECT_NEAR(p.inverse_z({3, 77}), 0.5, 1e-12);
  EXPECT_NEAR(p.signed_distance({40, 60}), 2.5, 1e-9);
  EXPECT_NEAR(p.signed_distance({34.5, 31}), -5, 1e-9) << "a corner: 3 to the left, 4 above";
  EXPECT_EQ(skip_reason(p), Skip::none);
}

TEST(Projection, DepthOfASlantedPlaneIsThatOfItsPoints) {
  const CameraModel camera = pinhole(100, 80, 100);
  const PolygonModel model = model_of({{{-1, 1, 1}, {1, 1, 1}, {1, 1, 9}, {-1, 1, 9}}});  // a floor below the camera
  const CaptureState state = at_origin(model);
  const ProjectedPolygon p = project(model, 0, camera, state, kNear);
  for (const glm::dvec3 point : {glm::dvec3(0.2, 1, 2), glm::dvec3(-0.5, 1, 7.5)}) {
    EXPECT_NEAR(p.inverse_z(camera.pixel_from_camera(point)), 1 / point.z, 1e-12);
  }
}

TEST(Projection, IsCutAtTheNearPlaneBeforeTheDivide) {
  const CameraModel camera = pinhole(100, 80, 100);
  // A floor from behind the camera to 4 m ahead. Without the cut its far corners' mirror images would spoil the box.
  const PolygonModel model = model_of({{{-1, 0.3, -2}, {-1, 0.3, 4}, {1, 0.3, 4}, {1, 0.3, -2}}});
  const ProjectedPolygon p = project(model, 0, camera, at_origin(model), 0.1);
  ASSERT_EQ(p.outline.size(), 4u);
  EXPECT_EQ(p.box.top, 47) << "the far edge: 40 + 100 * 0.3 / 4";
  EXPECT_EQ(p.box.bottom, 80);
  double lowest = 0;
  for (const glm::dvec2& corner : p.outline) lowest = std::max(lowest, corner.y);
  EXPECT_NEAR(lowest, 40 + 100 * 0.3 / 0.1, 1e-9);
  EXPECT_NE(skip_reason(p), Skip::outside);
}

TEST(Projection, SkipsBackFacesOutsideAndTiny) {
  const CameraModel camera = pinhole(100, 80, 100);
  auto back = facing_rectangle(-1, -1, 1, 1, 2);
  std::swap(back[1], back[3]);
  auto behind = facing_rectangle(-1, -1, 1, 1, -2);
  std::swap(behind[1], behind[3]);  // its front looks at the camera
  const PolygonModel model =
      model_of({back, facing_rectangle(5, 0, 6, 1, 2), behind, facing_rectangle(0.001, 0.001, 0.003, 0.003, 1),
                facing_rectangle(0.001, 0.001, 0.0035, 0.0035, 1)});
  const CaptureState state = at_origin(model);
  const auto reason = [&](std::size_t i) { return skip_reason(project(model, i, camera, state, kNear)); };
  EXPECT_EQ(reason(0), Skip::back_face);
  EXPECT_EQ(reason(1), Skip::outside);
  EXPECT_EQ(reason(2), Skip::outside) << "wholly behind the camera";
  EXPECT_EQ(reason(3), Skip::too_small) << "0.04 square pixels";
  EXPECT_EQ(reason(4), Skip::none) << "0.0625 square pixels";
}

TEST(Visibility, NearestWinsAndBackFacesOcclude) {
  const CameraModel camera = pinhole(40, 30, 40);
  auto back = facing_rectangle(-0.2, -0.2, 0.2, 0.2, 1);
  std::swap(back[1], back[3]);
  const PolygonModel model = model_of({facing_rectangle(-1, -1, 1, 1, 4), back});
  const Visibility seen = visibility(model, camera, at_origin(model), kNear);
  // The wall covers x 10..30, y 5..25; the back face before it x 12..28, y 7..23.
  EXPECT_EQ(seen.nearest.at(12, 7).polygon, 1);
  EXPECT_DOUBLE_EQ(seen.nearest.at(12, 7).inverse_z, 1);
  EXPECT_EQ(seen.nearest.at(11, 7).polygon, 0);
  EXPECT_DOUBLE_EQ(seen.nearest.at(11, 7).inverse_z, 0.25);
  EXPECT_EQ(seen.nearest.at(27, 22).polygon, 1);
  EXPECT_EQ(seen.nearest.at(28, 22).polygon, 0);
  EXPECT_EQ(seen.nearest.at(9, 7).polygon, -1);
  EXPECT_EQ(seen.candidates.at(20, 15).size(), 1u);
}

TEST(Visibility, PartsMoveWithTheirPoses) {
  const CameraModel camera = pinhole(40, 30, 40);
  const PolygonModel model = model_of({facing_rectangle(-2, -2, 2, 2, 4), facing_rectangle(-0.1, -0.1, 0.1, 0.1, 2)},
                                      {0, 1}, {"wall", "chip"});
  CaptureState state = at_origin(model);
  EXPECT_EQ(visibility(model, camera, state, kNear).nearest.at(20, 15).polygon, 1);
  state.world_from_part[1].translation = {0.5, 0, 0};
  const Visibility moved = visibility(model, camera, state, kNear);
  EXPECT_EQ(moved.nearest.at(20, 15).polygon, 0);
  EXPECT_EQ(moved.nearest.at(30, 15).polygon, 1);
  state.world_from_camera.translation = {0.5, 0, 0};
  EXPECT_EQ(visibility(model, camera, state, kNear).nearest.at(20, 15).polygon, 1);
}

/// A wall 4 m away (ten pixels a metre) with a chip before it.
struct WallAndChip {
  CameraModel camera = pinhole(40, 30, 40);
  PolygonModel model;
  CaptureState state;
  explicit WallAndChip(double chip_z)
      : model(model_of({facing_rectangle(-1.2, -0.8, 0.8, 0.8, 4),
                        facing_rectangle(-0.095 * chip_z, -0.1 * chip_z, 0.1 * chip_z, 0.1 * chip_z, chip_z)})),
        state(at_origin(model)) {}
  [[nodiscard]] double alpha(std::size_t polygon, int x, int y) const {
    const ProjectedPolygon p = project(model, polygon, camera, state, kNear);
    const Mask mask = occlusion_mask(model, polygon, p, visibility(model, camera, state, kNear), plain_picture(camera));
    return mask.alpha.at(x - p.grown_box.left, y - p.grown_box.top);
  }
};

TEST(Occlusion, InsideIsValidUnlessSomethingIsNearer) {
  const WallAndChip scene(2);  // the wall spans x 8..28, y 7..23; the chip 16.2..24, 11..19
  EXPECT_EQ(scene.alpha(0, 20, 15), 0);
  EXPECT_EQ(scene.alpha(0, 16, 11), 0);
  EXPECT_EQ(scene.alpha(0, 15, 15), 1);
  EXPECT_EQ(scene.alpha(0, 24, 15), 1);
  EXPECT_EQ(scene.alpha(1, 20, 15), 1);
  EXPECT_EQ(scene.alpha(1, 16, 11), 1);
}

TEST(Occlusion, TheBandLooksAtTheDepthOfTheNearestPointOfTheOutline) {
  // Nothing lies behind the wall's band: 31/32. Beyond the chip lies the wall, further away: 31/32 as well.
  const WallAndChip far(2);
  EXPECT_EQ(far.alpha(0, 6, 15), kOutside);
  EXPECT_EQ(far.alpha(1, 15, 15), kOutside);
  // A chip hardly nearer than the wall: within 2 per cent, so the wall's pixels beside it count as its own.
  const WallAndChip close(3.95);
  EXPECT_EQ(close.alpha(1, 15, 15), 1);
  EXPECT_EQ(close.alpha(1, 14, 15), 1) << "its centre is 1.7 pixels off";
  EXPECT_EQ(close.alpha(1, 13, 15), kOutside) << "its centre is 2.7 pixels off, yet in the box";
}

TEST(Occlusion, TheBandIsInvalidWhereAnOccluderHidesIt) {
  const CameraModel camera = pinhole(40, 30, 40);
  // A wall ends at x = 27.8; an occluder covers x 28..36, beyond it.
  const PolygonModel model =
      model_of({facing_rectangle(-1.2, -0.8, 0.78, 0.8, 4), facing_rectangle(0.4, -0.4, 0.8, 0.4, 2)});
  const CaptureState state = at_origin(model);
  const ProjectedPolygon wall = project(model, 0, camera, state, kNear);
  const Mask mask = occlusion_mask(model, 0, wall, visibility(model, camera, state, kNear), plain_picture(camera));
  const auto alpha = [&](int x) { return mask.alpha.at(x - wall.grown_box.left, 15 - wall.grown_box.top); };
  EXPECT_EQ(alpha(27), 1);
  EXPECT_EQ(alpha(28), 0);
  EXPECT_EQ(alpha(29), 0);
  EXPECT_EQ(alpha(30), kOutside) << "its centre is 2.7 pixels off";
}

TEST(Occlusion, ANeighbourAcrossASharedEdgeIsAlwaysValidInTheBand) {
  const CameraModel camera = pinhole(40, 30, 40);
  // A wall and a second one bent towards the camera by so much that its depth differs by more than 2 per cent.
  const PolygonModel model = model_of(
      {facing_rectangle(-1.2, -0.8, 0.4, 0.8, 4), {{0.4, -0.8, 4}, {0.4, 0.8, 4}, {0.5, 0.8, 2}, {0.5, -0.8, 2}}});
  const CaptureState state = at_origin(model);
  const ProjectedPolygon wall = project(model, 0, camera, state, kNear);
  const Visibility seen = visibility(model, camera, state, kNear);
  ASSERT_EQ(seen.nearest.at(24, 15).polygon, 1);
  ASSERT_GT(seen.nearest.at(25, 15).inverse_z, 0.25 * 1.1);
  const Mask mask = occlusion_mask(model, 0, wall, seen, plain_picture(camera));
  for (const int x : {24, 25}) EXPECT_EQ(mask.alpha.at(x - wall.grown_box.left, 15 - wall.grown_box.top), 1);
}

TEST(Occlusion, UnusablePixelsAreOutsideEverywhere) {
  const CameraModel camera = pinhole(40, 30, 40);
  const PolygonModel model = model_of({facing_rectangle(-4, -4, 4, 4, 4), facing_rectangle(-0.2, -0.2, 0.2, 0.2, 2)});
  const CaptureState state = at_origin(model);
  UndistortedPicture picture = plain_picture(camera);
  picture.usable.at(20, 15) = picture.usable.at(3, 4) = 0;
  const ProjectedPolygon wall = project(model, 0, camera, state, kNear);
  const Mask mask = occlusion_mask(model, 0, wall, visibility(model, camera, state, kNear), picture);
  EXPECT_EQ(mask.alpha.at(20, 15), kOutside) << "though it is occluded";
  EXPECT_EQ(mask.alpha.at(3, 4), kOutside);
  EXPECT_EQ(mask.alpha.at(4, 4), 1);
}

TEST(Occlusion, BoundsHoldTheMaskAndDifferOnlyWhereRoundingDecides) {
  const CameraModel camera = pinhole(80, 60, 80);
  const PolygonModel model = model_of({{{-0.9, -0.7, 3}, {-1, 0.8, 4}, {1.1, 0.75, 4.5}, {1, -0.8, 4.2}},
                                       {{-0.21, -0.33, 2}, {-0.3, 0.3, 2.1}, {0.33, 0.21, 2.2}}});
  const CaptureState state = at_origin(model);
  std::size_t doubtful = 0, all = 0;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const ProjectedPolygon p = project(model, i, camera, state, kNear);
    if (skip_reason(p) != Skip::none) continue;
    const Mask mask = occlusion_mask(model, i, p, visibility(model, camera, state, kNear), plain_picture(camera));
    for (std::size_t k = 0; k < mask.alpha.values.size(); ++k) {
      EXPECT_LE(mask.low.values[k], mask.alpha.values[k]);
      EXPECT_GE(mask.high.values[k], mask.alpha.values[k]);
      ++all;
      if (mask.low.values[k] != mask.high.values[k]) ++doubtful;
    }
  }
  EXPECT_GT(all, 1000u);
  EXPECT_LT(doubtful, all / 100);
}

}  // namespace
}  // namespace foreview::oracle
