#include <gtest/gtest.h>

#include "foreview/recordings/builtin.h"
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
TEST_F(GlTest, GoldenViewsOfTheWorkcell) {
  const test::TemporaryDirectory directory;
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
  Replayer replayer(options);
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

}  // namespace
}  // namespace foreview
