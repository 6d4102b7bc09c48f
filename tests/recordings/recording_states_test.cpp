#include <gtest/gtest.h>

#include "foreview/recordings/recording.h"
#include "log_capture.h"
#include "sample_recording.h"

namespace foreview {
namespace {

using test::encoded;
using test::patterned_picture;
using test::SampleRecording;

PolygonModel model_of(const std::vector<std::string>& parts) {
  RawMesh mesh;
  mesh.part_names = parts;
  for (std::uint32_t part = 0; part < parts.size(); ++part) {
    const std::uint32_t first = part * 3;
    const double x = 2.0 * part;
    mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
    mesh.faces.push_back({first, first + 1, first + 2});
    mesh.face_part.push_back(part);
  }
  ImportOptions options;
  options.backdrop = false;
  return build_polygon_model(mesh, options);
}

TEST(RecordingStates, DamagedPicturesAreCountedOnceAndLoggedOncePerKind) {
  const SampleRecording sample;
  sample.directory.write("rgb/a.png", sample.directory.read("rgb/a.png").substr(0, 200));
  sample.directory.write("rgb/b.jpg", encoded(patterned_picture(1, 1, 0), ".jpg"));
  const test::LogCapture log;
  Recording recording = sample.open();
  const PolygonModel model = model_of({"model"});
  EXPECT_FALSE(recording.read_frame(0, 0, model));
  EXPECT_FALSE(recording.read_frame(0, 0, model));
  EXPECT_FALSE(recording.read_frame(0, 1, model));
  EXPECT_EQ(recording.damage().pictures_unreadable, 2U);
  EXPECT_EQ(log.lines(), 1) << log.text();
  EXPECT_NE(log.text().find("a.png: is a PNG that is cut off"), std::string::npos) << log.text();
  try {
    static_cast<void>(recording.read_picture(0, 1));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("b.jpg: is 1x1 pixels; expected 16x12"), std::string::npos);
  }
  const std::optional<CameraFrame> frame = recording.read_frame(0, 2, model);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->picture.size(), cv::Size(16, 12));
  EXPECT_EQ(frame->camera.width, 16);
  EXPECT_EQ(frame->state.stamp.nanoseconds, 200000000);
  EXPECT_EQ(frame->state.world_from_camera.translation, glm::dvec3(1, 2, 0));
}

TEST(RecordingStates, PartsMoveAsRecordedAndStayWhereNothingIsRecorded) {
  const SampleRecording sample;
  sample.directory.write("parts/arm.txt", "0.0 0 0 0 0 0 0 1\n0.15 3 0 0 0 0 0 1\n");
  sample.directory.write("parts/table.txt", "0.05 0 0 5 0 0 0 1\n");
  sample.directory.write("parts/unknown.txt", "0.05 0 0 5 0 0 0 1\n0.06 0 0 5 0 0 0 1\n");
  sample.directory.write("parts/notes.md", "no poses");
  Recording recording = sample.open();
  EXPECT_EQ(recording.part_trajectories().size(), 3U);
  const PolygonModel model = model_of({"room", "table", "arm"});
  const std::optional<CaptureState> state = recording.capture_state(0, {50000000}, model);
  ASSERT_TRUE(state);
  ASSERT_EQ(state->world_from_part.size(), 3U);
  EXPECT_EQ(state->world_from_part[0], Pose());
  EXPECT_EQ(state->world_from_part[1].translation, glm::dvec3(0, 0, 5));
  EXPECT_NEAR(state->world_from_part[2].translation.x, 1, 1e-12);
  EXPECT_NEAR(state->world_from_camera.translation.x, 0.5, 1e-12);
  const std::optional<PredictedState> predicted = recording.predicted_state(0, {50000000}, model);
  ASSERT_TRUE(predicted);
  EXPECT_EQ(predicted->world_from_part, state->world_from_part);
  EXPECT_EQ(predicted->world_from_camera, state->world_from_camera);

  EXPECT_FALSE(recording.capture_state(0, {160000000}, model));  // the arm's record ends before
  EXPECT_TRUE(recording.capture_state(0, {160000000}, model_of({"room", "table"})));
  EXPECT_FALSE(recording.capture_state(0, {200000001}, model_of({"room"})));
  EXPECT_FALSE(recording.predicted_state(0, {-1}, model_of({"room"})));
  const test::LogCapture log;
  EXPECT_FALSE(recording.read_frame(0, 2, model));
  EXPECT_EQ(recording.damage().pictures_without_pose, 1U);
  EXPECT_EQ(log.lines(), 1);
}

}  // namespace
}  // namespace foreview
