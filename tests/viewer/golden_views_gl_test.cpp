#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "foreview/recordings/builtin.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/replay_frames.h"
#include "foreview/viewer/replayer.h"
#include "gpu/gl_test_fixture.h"
#include "support/golden_image.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

// Other drivers round edges, levels of detail and the generator's own libm differently: single pixels of a contour
// may change their side, so the maximum is no bound for them; the mean is what guards the picture.
constexpr testing::GoldenThresholds kAcrossRenderers{.maximum = 160, .mean = 0.6};

/// The workcell while the arm moves, at a third of its size, 0.2 s ahead: everything from the generator to the view.
ReplayOptions small_workcell(const std::filesystem::path& directory) {
  GenerateOptions generate;
  generate.name = "workcell";
  generate.first_picture = 60;
  generate.pictures = 8;
  generate.scale = 0.33;
  generate_recording(generate, directory / "workcell");
  ReplayOptions options;
  options.recording = directory / "workcell";
  options.delay = Duration::parse("200ms", "delay");
  options.density = 120;
  return options;
}

TEST_F(GlTest, GoldenViewsOfTheWorkcell) {
  const test::TemporaryDirectory directory;
  Replayer replayer(small_workcell(directory.path()));
  const Timestamp now = replayer.last();
  EXPECT_GT(replayer.advance_to(now), 0U);
  const PredictedState state = replayer.predicted_state(now).value();
  const CameraModel& camera = replayer.operator_camera();

  testing::expect_golden(replayer.view().render(camera, state), "workcell-predicted", kAcrossRenderers);
  ViewStyle holes;
  holes.holes_pink = true;
  testing::expect_golden(replayer.view().render(camera, state, holes), "workcell-holes", kAcrossRenderers);
  ViewStyle wireframe;
  wireframe.wireframe = true;
  testing::expect_golden(replayer.view().render(camera, state, wireframe), "workcell-wireframe", kAcrossRenderers);
}

struct GoldenFrame {
  const char* name;
  std::function<void(ViewChoice&)> choose;
  double silent = 0;  ///< seconds that nothing is heard
};

/// Every mode and overlay, as composed for window and file.
TEST_F(GlTest, GoldenFramesOfTheWorkcell) {
  const test::TemporaryDirectory directory;
  const ReplayOptions options = small_workcell(directory.path());
  Replayer replayer(options);
  const Timestamp now = replayer.last();
  replayer.advance_to(now);
  FrameComposer composer(replayer.view(), replayer.recording().cameras()[replayer.camera()].model, 0.02);
  ReplayFrames frames(replayer, options.delay);
  const cv::Mat polygons =
      replayer.view().render_surface(replayer.operator_camera(), replayer.predicted_state(now).value()).polygon;
  const auto in_the_middle = static_cast<std::uint32_t>(polygons.at<int>(polygons.rows / 2, polygons.cols / 2));
  const std::vector<GoldenFrame> golden{
      {"split", [](ViewChoice& c) { c.mode = ViewMode::split; }},
      {"split-edges",
       [](ViewChoice& c) {
         c.mode = ViewMode::split;
         c.split = 0.3;
         c.overlays.edges = c.overlays.wireframe = true;
       }},
      {"both-holes-edges",
       [](ViewChoice& c) {
         c.mode = ViewMode::side_by_side;
         c.overlays.holes = c.overlays.edges = true;
       }},
      {"difference", [](ViewChoice& c) { c.mode = ViewMode::difference; }},
      {"difference-unknown",
       [](ViewChoice& c) {
         c.mode = ViewMode::difference;
         c.field_of_view = 1.2;
       }},
      {"fast", [](ViewChoice& c) { c.quality = ViewQuality::fast; }},
      {"never-seen", [](ViewChoice& c) { c.overlays.never_seen = true; }},
      {"age",
       [](ViewChoice& c) {
         c.overlays.age = true;
         c.age_span = 0.5;
       }},
      {"density", [](ViewChoice& c) { c.overlays.density = true; }},
      {"polygon", [&](ViewChoice& c) { c.polygon = in_the_middle; }},
      {"look-around",
       [](ViewChoice& c) {
         c.camera = CameraMode::look_around;
         c.turn = {0.4, 0.1};
       }},
      {"overview-cone",
       [](ViewChoice& c) {
         c.camera = CameraMode::overview;
         c.overlays.cone = true;
       }},
      {"overview-all",
       [&](ViewChoice& c) {
         c.camera = CameraMode::overview;
         c.overlays = {true, true, true, true, true, true, true};
         c.polygon = in_the_middle;
       }},
      {"cone", [](ViewChoice& c) { c.overlays.cone = true; }},
      {"stale", [](ViewChoice&) {}, 3.1},
      {"stale-both", [](ViewChoice& c) { c.mode = ViewMode::side_by_side; }, 8},
  };
  for (const GoldenFrame& frame : golden) {
    ViewChoice choice;
    frame.choose(choice);
    FrameInput& input = frames.at(now, choice);
    if (frame.silent > 0) {
      StalenessInput known;
      known.now = now;
      known.expected_delay = options.delay;
      known.newest_picture = now - Duration::from_seconds(frame.silent);
      input.staleness = assess_staleness(known);
    }
    composer.compose(input, choice, composer.native_size(choice.mode));
    SCOPED_TRACE(frame.name);
    testing::expect_golden(composer.read(), std::string("workcell-frame-") + frame.name, kAcrossRenderers);
  }
}

}  // namespace
}  // namespace foreview
