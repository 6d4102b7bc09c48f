#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "foreview/recordings/recording.h"
#include "foreview/scene/output_file.h"
#include "sample_recording.h"

namespace foreview {
namespace {

using test::patterned_picture;
using test::TemporaryDirectory;

CameraModel small_camera(double focal_length) {
  CameraModel camera;
  camera.width = 21;
  camera.height = 13;
  camera.focal_length = {focal_length, focal_length * 1.01};
  camera.principal_point = {10.6123456789, 6.3987654321};
  camera.distortion_model = DistortionModel::plumb_bob;
  camera.distortion = {-0.2, 0.05, 1e-4, -2e-4, 0.01};
  return camera;
}

Pose odd_pose(int i) {
  const double a = 0.1 + 0.37 * i;
  return {glm::normalize(glm::dquat(std::cos(a), std::sin(a) / 3, -std::sin(2 * a), 0.7)),
          {1.0 / (3 + i), -123.456789012345 * i, 1e-7 * i}};
}

void expect_near(const Pose& a, const Pose& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a.translation[i], b.translation[i], 1e-9);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(a.rotation[i], b.rotation[i], 1e-9);
}

TEST(RecordingWriter, WritesWhatTheReaderReadsBackExactly) {
  const TemporaryDirectory directory;
  const std::filesystem::path target = directory / "new/stereo";
  RecordingWriter::Description description;
  description.name = "stereo: \"test\"";
  description.cameras = {{"left", small_camera(30)}, {"right eye", small_camera(31.0 / 7)}};
  description.scene_file = "scene.obj";
  description.import_options.merge_coplanar = false;
  description.import_options.max_merged_extent = 1.0 / 3;
  description.density = 123.5;
  description.max_texels = 64;
  description.initial_textures = "initial.bin";
  std::vector<Timestamp> stamps;
  for (int i = 0; i < 5; ++i) stamps.push_back({1700000000123456789 + i * 39999999});
  {
    RecordingWriter writer(target, description);
    writer.set_joint_names({"shoulder", "elbow"});
    for (int i = 0; i < 5; ++i) {
      const Timestamp stamp = stamps[static_cast<std::size_t>(i)];
      for (std::size_t camera = 0; camera < 2; ++camera) {
        const int seed = i + 10 * static_cast<int>(camera);
        writer.add_camera_pose(camera, stamp, odd_pose(seed));
        writer.add_picture(camera, stamp, patterned_picture(21, 13, seed), camera == 0 ? "png" : "jpg");
      }
      writer.add_part_pose("gripper left", stamp, odd_pose(i + 50));
      writer.add_joints(stamp, {0.1 * i, 1.0 / (1 + i)});
    }
    writer.finish();
  }
  directory.write("new/stereo/scene.obj", "x");
  directory.write("new/stereo/initial.bin", "x");

  const Recording recording = Recording::open(target);
  EXPECT_EQ(recording.damage().total(), 0U);
  EXPECT_EQ(recording.name(), description.name);
  EXPECT_EQ(recording.scene_file(), target / "scene.obj");
  EXPECT_EQ(recording.initial_textures(), target / "initial.bin");
  EXPECT_EQ(recording.import_options().merge_coplanar, false);
  EXPECT_EQ(recording.import_options().max_merged_extent, 1.0 / 3);
  EXPECT_EQ(recording.proposed_density(), 123.5);
  EXPECT_EQ(recording.proposed_max_texels(), 64);
  ASSERT_EQ(recording.cameras().size(), 2U);
  for (std::size_t camera = 0; camera < 2; ++camera) {
    const Recording::Camera& read = recording.cameras()[camera];
    EXPECT_EQ(read.name, description.cameras[camera].name);
    EXPECT_EQ(read.model.focal_length, description.cameras[camera].model.focal_length);
    EXPECT_NEAR(read.model.principal_point.x, 10.6123456789, 1e-12);
    EXPECT_EQ(read.model.distortion, description.cameras[camera].model.distortion);
    ASSERT_EQ(read.pictures.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
      const int seed = static_cast<int>(i + 10 * camera);
      EXPECT_EQ(read.pictures[i].stamp, stamps[i]);
      const std::optional<Pose> pose = read.world_from_camera.at(stamps[i]);
      ASSERT_TRUE(pose);
      expect_near(*pose, odd_pose(seed));
      const cv::Mat picture = recording.read_picture(camera, i);
      if (camera == 0) {
        EXPECT_EQ(cv::norm(picture, patterned_picture(21, 13, seed), cv::NORM_INF), 0);
      }
    }
  }
  const Trajectory& gripper = recording.part_trajectories().at("gripper left");
  ASSERT_EQ(gripper.size(), 5U);
  expect_near(gripper.samples()[4].pose, odd_pose(54));
  EXPECT_EQ(recording.joints().names, (std::vector<std::string>{"shoulder", "elbow"}));
  EXPECT_EQ(recording.joints().stamps, stamps);
  EXPECT_EQ(recording.joints().positions[3], (std::vector<double>{0.1 * 3, 1.0 / 4}));
}

TEST(RecordingWriter, SingleCameraLiesAtTheTopAndStampsMeanWhatWasSaid) {
  const TemporaryDirectory directory;
  RecordingWriter::Description description;
  description.name = "single";
  description.cameras = {{"", small_camera(30)}};
  description.stamp_meaning = StampMeaning::start_of_exposure;
  description.exposure = {10000001};
  RecordingWriter writer(directory.path(), description);
  writer.add_camera_pose(0, {0}, Pose());
  writer.add_camera_pose(0, {1000000000}, Pose());
  writer.add_picture(0, {500000000}, patterned_picture(21, 13, 1));
  // Even before finish(), all that was given is there and whole.
  const Recording recording = Recording::open(directory.path());
  EXPECT_EQ(recording.damage().total(), 0U);
  ASSERT_EQ(recording.cameras()[0].pictures.size(), 1U);
  EXPECT_EQ(recording.cameras()[0].pictures[0].stamp.nanoseconds, 505000000);
  EXPECT_EQ(directory.read("rgb.txt"), "# stamp file\n0.500000000 rgb/000000.jpg\n");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory.path())) {
    EXPECT_NE(entry.path().extension(), ".part");
  }
}

TEST(RecordingWriter, RefusesToMixRecordingsAndWhatTheReaderWouldRefuse) {
  const TemporaryDirectory directory;
  RecordingWriter::Description description;
  description.cameras = {{"", small_camera(30)}};
  { RecordingWriter writer(directory.path(), description); }
  EXPECT_THROW(RecordingWriter(directory.path(), description), InputError);
  EXPECT_THROW(RecordingWriter(directory / "recording.yaml", description), InputError);

  const auto refused = [&](const RecordingWriter::Description& d) {
    EXPECT_THROW(RecordingWriter(directory / "new", d), InputError);
    EXPECT_FALSE(std::filesystem::exists(directory / "new/recording.yaml"));
  };
  RecordingWriter::Description bad = description;
  bad.cameras = {{"a/b", small_camera(30)}};
  refused(bad);
  bad.cameras = {{"a", small_camera(30)}, {"a", small_camera(30)}};
  refused(bad);
  bad = description;
  bad.scene_file = "../scene.obj";
  refused(bad);
  bad = description;
  bad.stamp_meaning = StampMeaning::start_of_exposure;
  bad.exposure = {-1};
  refused(bad);
  bad = description;
  bad.cameras[0].model.focal_length.x = 0;
  refused(bad);

  RecordingWriter writer(directory / "parts", description);
  for (const char* part : {"", "a/b", "..", "../../x", "a\nb"}) {
    EXPECT_THROW(writer.add_part_pose(part, {0}, Pose()), InputError) << part;
  }
}

TEST(RecordingWriter, SaysWhichFileTheDiskRefused) {
  const TemporaryDirectory directory;
  RecordingWriter::Description description;
  description.cameras = {{"", small_camera(30)}};
  RecordingWriter writer(directory.path(), description);
  writer.add_camera_pose(0, {0}, Pose());
  writer.add_picture(0, {0}, patterned_picture(21, 13, 1));
  std::filesystem::remove_all(directory / "rgb");
  try {
    writer.add_picture(0, {1}, patterned_picture(21, 13, 1));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("rgb/000001.jpg: cannot be written"), std::string::npos) << error.what();
  }
  EXPECT_EQ(directory.read("rgb.txt"), "# stamp file\n0.000000000 rgb/000000.jpg\n");
}

// A file-size limit refuses writes in the middle, as a full disk does.
TEST(AtomicFile, LeavesNothingHalfWrittenWhenTheDiskIsFull) {
  const TemporaryDirectory directory;
  LineFile lines(directory / "lines.txt", "# header\n");
  lines.add("first");
  lines.flush();
  directory.write("whole.bin", "old");

  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 100;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  lines.add(std::string(500, 'x'));
  EXPECT_THROW(lines.flush(), InputError);
  EXPECT_THROW(write_file_whole(directory / "whole.bin", std::string(500, 'x')), InputError);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);

  EXPECT_EQ(directory.read("lines.txt"), "# header\nfirst\n");
  EXPECT_EQ(directory.read("whole.bin"), "old");
  EXPECT_FALSE(std::filesystem::exists(directory / "whole.bin.part"));
  lines.flush();
  EXPECT_EQ(directory.read("lines.txt"), "# header\nfirst\n" + std::string(500, 'x') + "\n");
}

}  // namespace
}  // namespace foreview
