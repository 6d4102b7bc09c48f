#include "foreview/recordings/recording.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "log_capture.h"
#include "sample_recording.h"

namespace foreview {
namespace {

using test::encoded;
using test::patterned_picture;
using test::SampleRecording;

TEST(Recording, OpensASmallOneWithoutAnyComplaint) {
  const SampleRecording sample;
  const test::LogCapture log;
  const Recording recording = sample.open();
  EXPECT_EQ(log.text(), "");
  EXPECT_EQ(recording.damage().total(), 0U);
  EXPECT_EQ(recording.name(), sample.directory.path().filename());
  ASSERT_EQ(recording.cameras().size(), 1U);
  const Recording::Camera& camera = recording.cameras()[0];
  EXPECT_EQ(camera.name, "eye");
  ASSERT_EQ(camera.pictures.size(), 3U);
  EXPECT_EQ(camera.pictures[1].stem, "b");
  EXPECT_EQ(camera.pictures[1].stamp.nanoseconds, 100000000);
  EXPECT_FALSE(recording.scene_file() || recording.proposed_density() || recording.initial_textures());
  EXPECT_TRUE(recording.part_trajectories().empty());
  EXPECT_TRUE(recording.joints().names.empty());
  const cv::Mat picture = recording.read_picture(0, 2);
  EXPECT_EQ(cv::norm(picture, patterned_picture(16, 12, 3), cv::NORM_INF), 0);
}

TEST(Recording, IsNamedAfterItsDirectoryHoweverThatIsWritten) {
  const SampleRecording sample;
  const std::string name = sample.directory.path().filename();
  EXPECT_EQ(Recording::open(sample.directory.path() / "").name(), name);
  EXPECT_EQ(Recording::open(sample.directory.path() / "rgb" / "..").name(), name);
}

TEST(Recording, ThatCannotBeUsedIsAnErrorOfOneLine) {
  const struct {
    const char *file, *content, *message;
  } cases[] = {
      {"camera.yaml", nullptr, "camera.yaml: no such file"},
      {"camera.yaml", "", "camera.yaml: image_width: is missing"},
      {"camera.yaml", "\xff\xfe\x01", "camera.yaml"},
      {"rgb.txt", nullptr, "rgb.txt: no such file"},
      {"rgb.txt", "", "rgb.txt: not one usable picture; expected lines 'stamp file'"},
      {"rgb.txt", "# only a comment\n", "rgb.txt: not one usable picture"},
      {"rgb.txt", "\x80\x81 \xff\n\x01\x02", "lines dropped, malformed; first rgb.txt:1: "},
      {"rgb.txt", "0.1 nowhere.png\n", "1 pictures dropped, file missing; first rgb.txt:1: "},
      {"rgb.txt", "7 rgb/a.png\n",
       "1 pictures dropped, no pose at their time; first rgb.txt:1: 7.000000000 is outside"},
      {"groundtruth.txt", nullptr, "groundtruth.txt: no such file"},
      {"groundtruth.txt", "", "groundtruth.txt: not one usable pose; expected lines"},
      {"groundtruth.txt", "0 nan 0 0 0 0 0 1\n", "1 poses dropped, not finite; first groundtruth.txt:1"},
      {"groundtruth.txt", "\x80\x81 \xff\n\x01\x02", "lines dropped, malformed; first groundtruth.txt:1: "},
      {"recording.yaml", "\x80\x81 [\xff\n\x01\x02", "recording.yaml"},
      {"recording.yaml", "cameras: [left]\n", "left/camera.yaml: no such file"},
      {"recording.yaml", "scene: {model: none.obj}\n", "recording.yaml: scene.model: no such file: none.obj"},
      {"recording.yaml", "textures: {initial: none}\n", "recording.yaml: textures.initial: no such directory: none"},
      {"joints.csv", "", "joints.csv: is empty"},
      {"parts/arm.txt", "", "parts/arm.txt: not one usable pose"},
      {"parts/arm.txt", "\xff\x80\n", "lines dropped, malformed; first parts/arm.txt:1: "},
  };
  for (const auto& c : cases) {
    const SampleRecording sample;
    if (c.content == nullptr) {
      std::filesystem::remove(sample.directory / c.file);
    } else {
      sample.directory.write(c.file, c.content);
    }
    const std::string message = sample.error();
    EXPECT_NE(message.find(c.message), std::string::npos) << c.file << " gives: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Recording, DirectoriesInPlaceOfFilesAndFilesInPlaceOfDirectoriesAreErrors) {
  for (const char* file :
       {"camera.yaml", "rgb.txt", "groundtruth.txt", "recording.yaml", "joints.csv", "parts/a.txt"}) {
    const SampleRecording sample;
    std::filesystem::remove(sample.directory / file);
    std::filesystem::create_directories(sample.directory / file);
    EXPECT_EQ(sample.error(), std::string(file) + ": is a directory; expected a file");
  }
  const SampleRecording sample;
  EXPECT_THROW(static_cast<void>(Recording::open(sample.directory / "camera.yaml")), InputError);
  EXPECT_THROW(static_cast<void>(Recording::open(sample.directory / "nowhere")), InputError);
  EXPECT_THROW(static_cast<void>(Recording::open("")), InputError);
  std::filesystem::remove(sample.directory / "rgb/b.jpg");
  std::filesystem::create_directories(sample.directory / "rgb/b.jpg");
  EXPECT_EQ(sample.open().damage().pictures_missing, 1U);
}

TEST(Recording, DropsCountsAndLogsDamagedItemsOncePerKind) {
  const SampleRecording sample;
  sample.directory.write("rgb.txt",
                         "0.2 rgb/c.png\n0.1 rgb/b.jpg\n0.0 rgb/a.png\n0.1 rgb/a.png\n0.15 rgb/no.png\n"
                         "0.16 rgb/neither.png\n0.3 rgb/a.png\n-0.1 rgb/a.png\nx y\n0.05 /etc/passwd\n");
  const test::LogCapture log;
  const Recording recording = sample.open();
  ASSERT_EQ(recording.cameras()[0].pictures.size(), 3U);
  EXPECT_EQ(recording.cameras()[0].pictures[0].stem, "a");
  EXPECT_EQ(recording.cameras()[0].pictures[1].stem, "b");  // the first of its stamp in the file
  const RecordingDamage& damage = recording.damage();
  EXPECT_EQ(damage.stamps_out_of_order, 6U);
  EXPECT_EQ(damage.stamps_duplicated, 1U);
  EXPECT_EQ(damage.pictures_missing, 2U);
  EXPECT_EQ(damage.pictures_without_pose, 2U);
  EXPECT_EQ(damage.lines_malformed, 2U);
  EXPECT_EQ(log.lines(), 5) << log.text();
}

TEST(Recording, ACameraOfOnePixelIsFine) {
  const SampleRecording sample;
  sample.directory.write("camera.yaml",
                         "image_width: 1\nimage_height: 1\ncamera_matrix: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n");
  sample.directory.write("rgb/a.png", encoded(patterned_picture(1, 1, 0), ".png"));
  const Recording recording = sample.open();
  EXPECT_EQ(recording.read_picture(0, 0).size(), cv::Size(1, 1));
  EXPECT_EQ(recording.cameras()[0].name, "camera");
}

TEST(Recording, StampsAtTheStartOfExposureMoveToItsMiddle) {
  const SampleRecording sample;
  sample.directory.write("recording.yaml", "stamp: start_of_exposure\nexposure: 20ms\n");
  const Recording recording = sample.open();
  ASSERT_EQ(recording.cameras()[0].pictures.size(), 2U);  // the last one's middle lies after the last pose
  EXPECT_EQ(recording.cameras()[0].pictures[0].stamp.nanoseconds, 10000000);
  EXPECT_EQ(recording.damage().pictures_without_pose, 1U);
}

TEST(Recording, StemsAreUnique) {
  const SampleRecording sample;
  sample.directory.write("more/a.png", sample.directory.read("rgb/a.png"));
  sample.directory.write("rgb.txt", "0 rgb/a.png\n0.1 more/a.png\n0.2 rgb/a.png\n");
  const Recording recording = sample.open();
  const auto& pictures = recording.cameras()[0].pictures;
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(pictures[0].stem, "a");
  EXPECT_EQ(pictures[1].stem, "a-1");
  EXPECT_EQ(pictures[2].stem, "a-2");
}

TEST(Recording, FindsTheSceneModelAndItsOptions) {
  const SampleRecording sample;
  sample.directory.write("scene.dae", "x");
  EXPECT_EQ(sample.open().scene_file(), sample.directory / "scene.dae");
  sample.directory.write("scene.ply", "x");
  EXPECT_EQ(sample.open().scene_file(), sample.directory / "scene.ply");
  sample.directory.write("other/cell.stl", "x");
  sample.directory.write("start/a.bin", "x");
  sample.directory.write("recording.yaml",
                         "name: cell\nscene: {model: other/cell.stl, scale: 0.001, backdrop: off}\n"
                         "textures: {density: 250, max_texels: 64, initial: start}\n");
  const Recording recording = sample.open();
  EXPECT_EQ(recording.name(), "cell");
  EXPECT_EQ(recording.scene_file(), sample.directory / "other/cell.stl");
  EXPECT_EQ(recording.import_options().scale, 0.001);
  EXPECT_FALSE(recording.import_options().backdrop);
  EXPECT_EQ(recording.proposed_density(), 250);
  EXPECT_EQ(recording.proposed_max_texels(), 64);
  EXPECT_EQ(recording.initial_textures(), sample.directory / "start");
}

TEST(Recording, PositionsAreIndicesOrTimesSinceTheStart) {
  const SampleRecording sample;
  sample.directory.write("groundtruth.txt", "1000.0 0 0 0 0 0 0 1\n1000.2 0 0 0 0 0 0 1\n");
  sample.directory.write("rgb.txt", "1000.0 rgb/a.png\n1000.1 rgb/b.jpg\n1000.2 rgb/c.png\n");
  const Recording recording = sample.open();
  const auto at = [&](const char* text) { return recording.parse_position(text, "--from").nanoseconds; };
  EXPECT_EQ(at("#0"), 1000000000000);
  EXPECT_EQ(at("#2"), 1000200000000);
  EXPECT_EQ(at("0"), 1000000000000);
  EXPECT_EQ(at("0.15"), 1000150000000);
  EXPECT_EQ(at("150ms"), 1000150000000);
  EXPECT_EQ(at("3.5s"), 1003500000000);
  for (const char* text : {"#3", "#", "#-1", "#1x", "# 1", "-1", "", "soon", "1e10", "nan", "#99999999999999999999"}) {
    try {
      static_cast<void>(recording.parse_position(text, "--from"));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find("--from: "), 0U) << error.what();
    }
  }
  EXPECT_EQ(recording.newest_before(0, {1000000000000}), std::nullopt);
  EXPECT_EQ(recording.newest_before(0, {1000000000001}), 0U);
  EXPECT_EQ(recording.newest_before(0, {1000100000000}), 0U);
  EXPECT_EQ(recording.newest_before(0, {2000000000000}), 2U);
  EXPECT_EQ(recording.last_stamp().nanoseconds, 1000200000000);
}

TEST(Recording, SeveralCamerasLieInDirectoriesOfTheirOwn) {
  const SampleRecording sample;
  for (const char* file : {"camera.yaml", "rgb.txt", "groundtruth.txt", "rgb"}) {
    std::filesystem::create_directories(sample.directory / "left");
    std::filesystem::create_directories(sample.directory / "right");
    std::filesystem::copy(sample.directory / file, sample.directory / "left" / file,
                          std::filesystem::copy_options::recursive);
    std::filesystem::rename(sample.directory / file, sample.directory / "right" / file);
  }
  sample.directory.write("right/rgb.txt", "0.1 rgb/b.jpg\n");
  sample.directory.write("recording.yaml", "cameras: [left, right]\n");
  const Recording recording = sample.open();
  ASSERT_EQ(recording.cameras().size(), 2U);
  EXPECT_EQ(recording.camera_index(""), 0U);
  EXPECT_EQ(recording.camera_index("right"), 1U);
  EXPECT_EQ(recording.cameras()[1].name, "right");
  EXPECT_EQ(recording.cameras()[1].pictures.size(), 1U);
  EXPECT_EQ(recording.first_stamp(1).nanoseconds, 100000000);
  EXPECT_EQ(recording.read_picture(1, 0).size(), cv::Size(16, 12));
  try {
    static_cast<void>(recording.camera_index("middle"));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "camera 'middle': is not in the recording; there are: left, right");
  }
}

TEST(Recording, JointsAreKept) {
  const SampleRecording sample;
  sample.directory.write("joints.csv", "stamp,a,b\n0.1,1,2\nbroken\n");
  const test::LogCapture log;
  const Recording recording = sample.open();
  EXPECT_EQ(recording.joints().names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(recording.joints().positions, (std::vector<std::vector<double>>{{1, 2}}));
  EXPECT_EQ(recording.damage().lines_malformed, 1U);
}

TEST(Recording, TheKitchenLoadsAsItIs) {
  const std::filesystem::path kitchen = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings" / "kitchen";
  if (!std::filesystem::exists(kitchen / "rgb.txt")) GTEST_SKIP() << "no kitchen recording at " << kitchen;
  const test::LogCapture log;
  const Recording recording = Recording::open(kitchen);
  EXPECT_EQ(log.text(), "");
  EXPECT_EQ(recording.damage().total(), 0U);
  EXPECT_EQ(recording.name(), "kitchen");
  ASSERT_EQ(recording.cameras().size(), 1U);
  const Recording::Camera& camera = recording.cameras()[0];
  EXPECT_EQ(camera.model.principal_point, glm::dvec2(320.5, 240.5));
  EXPECT_EQ(camera.model.focal_length, glm::dvec2(525, 525));
  ASSERT_EQ(camera.pictures.size(), 600U);
  EXPECT_EQ(camera.pictures[599].stem, "000599");
  EXPECT_EQ(recording.scene_file(), kitchen / "scene.ply");
  for (const Recording::PictureEntry& picture : camera.pictures) {
    EXPECT_TRUE(camera.world_from_camera.at(picture.stamp)) << picture.stem;
  }
  EXPECT_NEAR(camera.world_from_camera.at(camera.pictures[1].stamp)->translation.x, -0.3386620, 1e-9);
  for (std::size_t i = 0; i < 600; i += 100) EXPECT_EQ(recording.read_picture(0, i).size(), cv::Size(640, 480));
}

}  // namespace
}  // namespace foreview
