#include "foreview/viewer/replayer.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "foreview/scene/errors.h"
#include "gpu/gl_test_fixture.h"
#include "support/temporary_directory.h"
#include "viewer/small_recording.h"

namespace foreview {
namespace {

class ReplayerTest : public GlTest {
 protected:
  [[nodiscard]] ReplayOptions options(const char* delay = "200ms") const {
    ReplayOptions result;
    result.recording = directory_ / "recording";
    result.delay = Duration::parse(delay, "delay");
    result.density = 60;
    result.max_texels = 256;
    return result;
  }
  static std::vector<cv::Mat> pages_at(Replayer& replayer, Timestamp t) {
    replayer.advance_to(t);
    return replayer.store().read_pages();
  }
  static bool equal(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (a[i].size() != b[i].size() || cv::norm(a[i], b[i], cv::NORM_INF) != 0) return false;
    }
    return true;
  }
  static std::string refusal(const ReplayOptions& options) {
    try {
      const Replayer replayer(options);
      return "taken";
    } catch (const InputError& error) {
      return error.what();
    }
  }
  test::TemporaryDirectory directory_;
  test::SmallSite site_;
};

TEST_F(ReplayerTest, UsesPicturesCapturedStrictlyBeforeTheDelay) {
  site_.write(directory_ / "recording");
  Replayer replayer(options());
  EXPECT_FALSE(replayer.newest_used().has_value());
  // At instant 2 the picture of instant 0 is exactly 200 ms old: not yet.
  EXPECT_EQ(replayer.advance_to(site_.stamp(2)), 0U);
  EXPECT_FALSE(replayer.newest_used().has_value());
  EXPECT_EQ(replayer.advance_to(site_.stamp(2) + Duration{1}), 1U);
  EXPECT_EQ(replayer.newest_used(), 0U);
  EXPECT_EQ(replayer.advance_to(site_.stamp(6)), 3U);  // 1, 2, 3
  EXPECT_EQ(replayer.newest_used(), 3U);
  EXPECT_EQ(replayer.advance_to(site_.stamp(6)), 0U);
  EXPECT_EQ(replayer.pictures_extracted(), 4U);
  EXPECT_GT(replayer.statistics().polygons_visible, 4U);
  EXPECT_GT(replayer.extraction_seconds(), 0);
}

TEST_F(ReplayerTest, TexturesDependOnTheTimeAlone) {
  site_.write(directory_ / "recording");
  for (const std::optional<std::size_t> history : {std::optional<std::size_t>(), std::optional<std::size_t>(2)}) {
    ReplayOptions with = options();
    with.history = history;
    Replayer straight(with), wandering(with);
    const auto early = pages_at(straight, site_.stamp(5)), late = pages_at(straight, site_.stamp(9));
    EXPECT_FALSE(equal(early, late));
    EXPECT_TRUE(equal(late, pages_at(wandering, site_.stamp(9))));
    EXPECT_TRUE(equal(early, pages_at(wandering, site_.stamp(5))));
    EXPECT_TRUE(equal(late, pages_at(wandering, site_.stamp(9))));
    // Before any picture: nothing.
    wandering.advance_to(site_.stamp(1));
    EXPECT_FALSE(wandering.newest_used().has_value());
    EXPECT_EQ(wandering.store().count_observed_texels(), 0U);
  }
}

TEST_F(ReplayerTest, HistoryTakesOnlyTheLastPictures) {
  site_.write(directory_ / "recording");
  ReplayOptions with = options();
  with.history = 2;
  Replayer replayer(with);
  EXPECT_EQ(replayer.advance_to(site_.stamp(7)), 2U);  // 3, 4
  EXPECT_EQ(replayer.newest_used(), 4U);
  EXPECT_EQ(replayer.advance_to(site_.stamp(8)), 2U);  // afresh: 4, 5
  EXPECT_EQ(replayer.newest_used(), 5U);
  with.history = 100;
  EXPECT_EQ(Replayer(with).advance_to(site_.stamp(8)), 6U);
}

TEST_F(ReplayerTest, AllCamerasGiveTexturesInOrderOfCapture) {
  site_.cameras = 2;
  site_.write(directory_ / "recording");
  ReplayOptions with = options();
  with.camera = "right";
  Replayer replayer(with);
  EXPECT_EQ(replayer.camera(), 1U);
  EXPECT_EQ(replayer.advance_to(site_.stamp(5)), 6U);
  EXPECT_EQ(replayer.newest_used(), 2U);
  ASSERT_TRUE(replayer.last_used().has_value());
  EXPECT_EQ(replayer.last_used()->camera, 1U);
  EXPECT_EQ(replayer.last_used()->index, 2U);
  const auto state = replayer.predicted_state(site_.stamp(5));
  ASSERT_TRUE(state.has_value());
  EXPECT_NEAR(glm::distance(state->world_from_camera.translation,
                            test::SmallSite::world_from_camera(1, site_.stamp(5)).translation),
              0, 1e-6);
}

TEST_F(ReplayerTest, DamagedPicturesAreSkippedCountedAndReplacedInTheHistory) {
  site_.write(directory_ / "recording");
  std::filesystem::path file;
  {
    const Recording recording = Recording::open(directory_ / "recording");
    file = recording.cameras()[0].pictures[4].file;
  }
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  Replayer all(options());
  EXPECT_EQ(all.advance_to(site_.stamp(7)), 4U);  // 0 ... 3
  EXPECT_EQ(all.newest_used(), 3U);
  EXPECT_EQ(all.pictures_damaged(), 1U);
  EXPECT_EQ(all.recording().damage().pictures_unreadable, 1U);
  EXPECT_THROW((void)all.undistorted_picture(4), InputError);
  ReplayOptions with = options();
  with.history = 2;
  Replayer last(with);
  last.advance_to(site_.stamp(7));
  EXPECT_EQ(last.newest_used(), 3U);
  with.delay = with.delay + Duration{100'000'000};
  Replayer clean(with);
  EXPECT_TRUE(equal(pages_at(last, site_.stamp(7)), pages_at(clean, site_.stamp(7))));
}

TEST_F(ReplayerTest, SpanIsCutToFromAndTo) {
  site_.write(directory_ / "recording");
  ReplayOptions with = options();
  EXPECT_EQ(Replayer(with).first(), site_.stamp(0));
  EXPECT_EQ(Replayer(with).last(), site_.stamp(9));
  with.from = "#3";
  with.to = "650ms";
  EXPECT_EQ(Replayer(with).first(), site_.stamp(3));
  EXPECT_EQ(Replayer(with).last(), site_.stamp(6) + Duration{50'000'000});
}

TEST_F(ReplayerTest, RefusesWhatCannotBeUsed) {
  site_.write(directory_ / "recording");
  ReplayOptions with = options();
  with.recording = directory_ / "nothing-here";
  EXPECT_NE(refusal(with).find("nor a built-in recording"), std::string::npos) << refusal(with);
  with = options();
  with.scene = "no-such.ply";
  EXPECT_NE(refusal(with).find("--scene"), std::string::npos) << refusal(with);
  with = options();
  with.camera = "third";
  EXPECT_NE(refusal(with), "taken");
  with = options();
  with.from = "#7";
  with.to = "#3";
  EXPECT_NE(refusal(with).find("--to"), std::string::npos) << refusal(with);
  with = options();
  with.from = "120ms";
  with.to = "180ms";
  EXPECT_NE(refusal(with).find("no usable picture"), std::string::npos) << refusal(with);
  std::filesystem::remove(directory_ / "recording/scene.obj");
  EXPECT_NE(refusal(options()).find("scene.obj"), std::string::npos) << refusal(options());
}

TEST_F(ReplayerTest, SceneIsAlsoLookedForInTheRecording) {
  site_.write(directory_ / "recording");
  RawMesh wall = test::SmallSite::mesh();
  wall.faces.pop_back();
  wall.face_part.pop_back();
  write_obj(wall, directory_ / "recording/wall.obj");
  ReplayOptions with = options();
  with.scene = "wall.obj";
  EXPECT_LT(Replayer(with).model().polygons().size(), Replayer(options()).model().polygons().size());
}

TEST_F(ReplayerTest, SavedTexturesAreWhereTheNextRunBegins) {
  site_.write(directory_ / "recording");
  ReplayOptions with = options();
  with.save_textures = directory_ / "kept";
  Replayer first(with);
  const auto pages = pages_at(first, site_.stamp(9));
  first.save_textures_if_asked();
  with.save_textures.reset();
  with.load_textures = directory_ / "kept";
  Replayer second(with);
  EXPECT_EQ(second.store().count_observed_texels(), first.store().count_observed_texels());
  EXPECT_GT(second.store().count_observed_texels(), 0U);
  // What another model's textures are, they are not.
  with.density = 30;
  EXPECT_NE(refusal(with), "taken");
}

}  // namespace
}  // namespace foreview
