#include "foreview/viewer/polygon_probe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "foreview/viewer/replay_frames.h"
#include "gpu/gl_test_fixture.h"
#include "support/temporary_directory.h"
#include "viewer/painted_scene.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

using namespace test;

constexpr FrameComposer::Size kFrame{96, 48};
constexpr Rgb kRed{200, 30, 20};

class PolygonProbeTest : public GlTest {
 protected:
  /// Six squares in two rows, 2 m away; the last one never seen, the one before it filled.
  PolygonProbeTest() : scene_(facing_rectangle(3, 2, 2, 3, 2), options()) {
    for (std::size_t i = 0; i < 5; ++i) scene_.paint(i, kRed, i < 4);
    scene_.upload();
    input_.predicted = scene_.seen_from({});
  }
  static ChartOptions options() {
    ChartOptions result;
    result.texels_per_metre = 30;
    result.group_polygons = false;
    return result;
  }
  /// What is found once all is answered.
  void settle(PolygonProbe& probe, const ViewChoice& choice, std::optional<glm::dvec2> cursor) {
    for (int i = 0; i < 4; ++i) {
      probe.update(input_, choice, kFrame, cursor);
      glFinish();
    }
    probe.update(input_, choice, kFrame, cursor);
  }

  PaintedScene scene_;
  FrameInput input_;
};

TEST_F(PolygonProbeTest, FindsWhatTheFrameShows) {
  PolygonProbe probe(scene_.view(), pinhole(96, 48, 40), 0.02);
  for (const Pose& pose : {Pose{}, looking_at({0.3, -0.2, 0.1}, {0.1, 0.2, 2}, {0, -1, 0})}) {
    input_.predicted = scene_.seen_from(pose);
    for (int y = 3; y < 48; y += 8) {
      for (int x = 3; x < 96; x += 8) {
        settle(probe, {}, glm::dvec2(x + 0.2, y + 0.7));
        const glm::dvec3 ray = pose.rotate(pinhole(96, 48, 40).ray_from_pixel({x + 0.5, y + 0.5}));
        const glm::dvec3 p = pose.translation + ray * ((2 - pose.translation.z) / ray.z);
        const bool on_edge = std::abs(std::remainder(p.x + 0.5, 1)) < 0.02 || std::abs(std::remainder(p.y, 1)) < 0.02;
        if (on_edge) continue;
        if (std::abs(p.x) > 1.5 || std::abs(p.y) > 1) {
          EXPECT_FALSE(probe.found()) << x << ", " << y;
          EXPECT_FALSE(probe.report()) << x << ", " << y;
          continue;
        }
        ASSERT_TRUE(probe.found()) << x << ", " << y;
        EXPECT_EQ(probe.found()->polygon, (p.y > 0 ? 3U : 0U) + static_cast<std::uint32_t>(p.x + 1.5));
        EXPECT_LT(glm::distance(probe.found()->point_in_world, p), 1e-4);
        EXPECT_NEAR(probe.found()->distance, (pose.inverse() * p).z, 1e-5);
        ASSERT_TRUE(probe.report());
        EXPECT_EQ(probe.report()->polygon, probe.found()->polygon);
      }
    }
  }
}

TEST_F(PolygonProbeTest, TellsSeenFromFilledFromNeverSeen) {
  PolygonProbe probe(scene_.view(), pinhole(96, 48, 40), 0.02);
  using Provenance = PolygonProbe::Found::Provenance;
  settle(probe, {}, glm::dvec2(48, 14));
  EXPECT_EQ(probe.found()->provenance, Provenance::observed);
  EXPECT_NEAR(static_cast<double>(probe.report()->texels), 900, 61);
  EXPECT_EQ(probe.report()->observed_share, 1);
  settle(probe, {}, glm::dvec2(48, 34));
  EXPECT_EQ(probe.found()->provenance, Provenance::filled);
  EXPECT_EQ(probe.report()->observed_share, 0);
  settle(probe, {}, glm::dvec2(68, 34));
  EXPECT_EQ(probe.found()->provenance, Provenance::never_seen);
  EXPECT_FALSE(probe.found()->captured);
}

TEST_F(PolygonProbeTest, OnlyWhereThePredictedViewIs) {
  PolygonProbe probe(scene_.view(), pinhole(96, 48, 40), 0.02);
  ViewChoice choice;
  settle(probe, choice, glm::dvec2(60, 20));
  EXPECT_TRUE(probe.found());
  settle(probe, choice, std::nullopt);
  EXPECT_FALSE(probe.found());
  settle(probe, choice, glm::dvec2(-1, 20));
  EXPECT_FALSE(probe.found());
  settle(probe, choice, glm::dvec2(60, 48));
  EXPECT_FALSE(probe.found());
  choice.mode = ViewMode::split;
  choice.split = 0.5;
  settle(probe, choice, glm::dvec2(60, 20));
  EXPECT_FALSE(probe.found()) << "there is the delayed picture";
  settle(probe, choice, glm::dvec2(40, 20));
  EXPECT_TRUE(probe.found());
  choice.mode = ViewMode::side_by_side;
  settle(probe, choice, glm::dvec2(24, 24));
  ASSERT_TRUE(probe.found());
  EXPECT_LT(glm::distance(probe.found()->point_in_world, glm::dvec3(0, 0, 2)), 0.1) << "the middle of the left half";
  choice.mode = ViewMode::delayed;
  settle(probe, choice, glm::dvec2(24, 24));
  EXPECT_FALSE(probe.found());
  input_.predicted.reset();
  settle(probe, {}, glm::dvec2(24, 24));
  EXPECT_FALSE(probe.found());
}

TEST_F(GlTest, PolygonProbeTellsWhenAndByWhichPicturesATextureChanged) {
  const TemporaryDirectory directory;
  WallRecording::write(directory / "wall", 12);
  ReplayOptions options;
  options.recording = directory / "wall";
  options.delay = Duration::parse("120ms", "delay");
  Replayer replayer(options);
  const Recording::Camera& camera = replayer.recording().cameras()[replayer.camera()];
  ReplayFrames frames(replayer, options.delay);
  PolygonProbe probe(replayer.view(), camera.model, 0.02);
  const FrameComposer::Size size{camera.model.width, camera.model.height};
  const glm::dvec2 middle(0.5 * size.width, 0.5 * size.height);
  for (const std::size_t at : {6U, 7U, 8U}) {
    const Timestamp t = camera.pictures[at].stamp;
    replayer.advance_to(t);
    const FrameInput& input = frames.at(t, {});
    for (int i = 0; i < 5; ++i) {
      probe.update(input, {}, size, middle);
      glFinish();
    }
    ASSERT_TRUE(probe.found() && probe.report());
    ASSERT_FALSE(probe.report()->captures.empty());
    const Timestamp newest = camera.pictures[replayer.newest_used().value()].stamp;
    EXPECT_NEAR(probe.report()->captures.front().stamp.seconds(), newest.seconds(), 0.001);
    ASSERT_TRUE(probe.found()->captured);
    EXPECT_NEAR(probe.found()->captured->seconds(), newest.seconds(), 0.001);
    EXPECT_GT(probe.report()->observed_share, 0.3);
  }
  EXPECT_EQ(probe.report()->changed_by.size(), 2U) << "while it was looked at";
  EXPECT_EQ(probe.report()->changed_by.front(), replayer.store().pictures_ended());
}

}  // namespace
}  // namespace foreview
