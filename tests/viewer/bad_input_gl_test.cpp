// What recordings get wrong in real life, as their owner meets it: through the executable. Every case ends in one clear
// line and status 2, or in a run to the end that says what it left out.
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"
#include "viewer/run_foreview.h"
#include "viewer/wall_recording.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using test::Finished;
using test::run_foreview;
using test::TemporaryDirectory;
using test::WallRecording;

constexpr int kPictures = 8;
/// With a delay of three pictures, those before the fourth last are used.
constexpr const char* kDelay = "120ms";
constexpr int kUsed = kPictures - 4;

/// A sound recording, made once.
const fs::path& sound_recording() {
  static const TemporaryDirectory directory;
  static const fs::path path = [] {
    WallRecording::write(directory.path() / "wall", kPictures);
    return directory.path() / "wall";
  }();
  return path;
}

class BadInput : public ::testing::Test {
 protected:
  BadInput() { fs::copy(sound_recording(), recording(), fs::copy_options::recursive); }

  [[nodiscard]] fs::path recording() const { return directory_ / "wall"; }
  [[nodiscard]] std::string read(const std::string& file) const { return directory_.read("wall/" + file); }
  void write(const std::string& file, const std::string& content) const { directory_.write("wall/" + file, content); }
  [[nodiscard]] std::vector<std::string> lines_of(const std::string& file) const {
    std::istringstream stream(read(file));
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);)
      if (!line.empty() && line[0] != '#') lines.push_back(line);
    return lines;
  }
  void write_lines(const std::string& file, const std::vector<std::string>& lines) const {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    write(file, text);
  }
  /// The file that the recording's list names for a picture.
  [[nodiscard]] std::string picture_file(int index) const {
    const std::string line = lines_of("rgb.txt").at(static_cast<std::size_t>(index));
    return line.substr(line.find(' ') + 1);
  }

  struct Replayed {
    Finished run;
    nlohmann::json summary;
    std::vector<cv::Mat> pictures;
  };
  [[nodiscard]] Replayed replay(std::vector<std::string> more = {}) const {
    const fs::path out = directory_ / "out";
    fs::remove_all(out);
    std::vector<std::string> arguments{"replay",
                                       recording().string(),
                                       "--headless",
                                       "--out",
                                       out.string(),
                                       "--delay",
                                       kDelay,
                                       "--json",
                                       (directory_ / "summary.json").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Replayed result{run_foreview(arguments), {}, {}};
    std::vector<fs::path> files;
    if (fs::exists(out)) {
      for (const auto& entry : fs::recursive_directory_iterator(out)) {
        if (entry.is_regular_file()) files.push_back(entry.path());
      }
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) result.pictures.push_back(cv::imread(file.string()));
    std::ifstream stream(directory_ / "summary.json");
    if (stream) result.summary = nlohmann::json::parse(stream);
    return result;
  }
  void expect_refused(const std::string& mentions, std::vector<std::string> more = {}) const {
    more.emplace_back("--quiet");
    const Finished run = replay(std::move(more)).run;
    EXPECT_EQ(run.status, 2) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.err.rfind("foreview: ", 0), 0U) << run.err;
    EXPECT_NE(run.err.find(mentions), std::string::npos) << run.err << "\nexpected to mention " << mentions;
  }
  static void expect_said(const Replayed& replayed, const std::string& what) {
    EXPECT_NE(replayed.run.err.find(what), std::string::npos) << replayed.run.err << "\nexpected to say " << what;
  }
  /// Ran to the end, and the last picture is a good prediction.
  static void expect_good(const Replayed& replayed) {
    ASSERT_EQ(replayed.run.status, 0) << replayed.run.err;
    ASSERT_EQ(replayed.pictures.size(), std::size_t{kPictures});
    EXPECT_GT(cv::PSNR(replayed.pictures.back(), WallRecording::truth(kPictures - 1)), 24);
  }
  /// The wall's model with more behind it in the same file; `faces` count from the first of `vertices` as 1.
  void add_to_model(const std::vector<std::string>& vertices, const std::vector<std::vector<int>>& faces) const {
    std::string text = read("scene.obj");
    int first = 0;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) first += line.rfind("v ", 0) == 0 ? 1 : 0;
    for (const std::string& vertex : vertices) text += "v " + vertex + "\n";
    for (const std::vector<int>& face : faces) {
      text += "f";
      for (const int corner : face) text += " " + std::to_string(first + corner);
      text += "\n";
    }
    write("scene.obj", text);
  }

  TemporaryDirectory directory_;
};

TEST_F(BadInput, TheSoundRecordingGivesNoReasonToComplain) {
  const Replayed replayed = replay();
  expect_good(replayed);
  EXPECT_EQ(replayed.summary["items_damaged"], 0);
  EXPECT_EQ(replayed.summary["pictures_extracted"], kUsed);
  EXPECT_EQ(replayed.run.err.find("warning"), std::string::npos) << replayed.run.err;
}

TEST_F(BadInput, MissingFiles) {
  for (const std::string file : {"camera.yaml", "rgb.txt", "groundtruth.txt", "scene.obj"}) {
    const std::string content = read(file);
    fs::remove(recording() / file);
    expect_refused(file);
    write(file, content);
  }
  fs::remove_all(recording());
  expect_refused("no such directory");
}

TEST_F(BadInput, EmptyFiles) {
  for (const std::string file : {"camera.yaml", "rgb.txt", "groundtruth.txt", "scene.obj"}) {
    const std::string content = read(file);
    write(file, "");
    expect_refused(file);
    write(file, content);
  }
}

TEST_F(BadInput, EveryPictureMissing) {
  for (int i = 0; i < kPictures; ++i) fs::remove(recording() / picture_file(i));
  expect_refused("8 pictures dropped, file missing");
}

TEST_F(BadInput, CutOffEmptyAndForeignPicturesAreLeftOut) {
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", WallRecording::truth(0), jpeg);
  std::vector<std::string> list = lines_of("rgb.txt");
  list[0] = list[0].substr(0, list[0].find(' ')) + " cut.jpg";
  const std::string whole = read(picture_file(1));
  write_lines("rgb.txt", list);
  write("cut.jpg", {jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() * 2 / 3)});
  write(picture_file(1), whole.substr(0, whole.size() * 2 / 3));
  write(picture_file(2), "");
  const Replayed replayed = replay({"--view", "both"});
  ASSERT_EQ(replayed.run.status, 0) << replayed.run.err;
  EXPECT_EQ(replayed.pictures.size(), std::size_t{kPictures});
  EXPECT_EQ(replayed.summary["pictures_unreadable"], 3);
  EXPECT_EQ(replayed.summary["pictures_extracted"], kUsed - 3);
  expect_said(replayed, "3 picture(s) could not be read");
  expect_said(replayed, "cut.jpg: is a JPEG that is cut off");
}

TEST_F(BadInput, PicturesUnlikeTheCamerasSize) {
  cv::imwrite((recording() / picture_file(1)).string(),
              cv::Mat(WallRecording::kWidth, WallRecording::kHeight, CV_8UC3));
  const Replayed one = replay();
  expect_good(one);
  EXPECT_EQ(one.summary["pictures_unreadable"], 1);
  EXPECT_EQ(one.summary["pictures_extracted"], kUsed - 1);
  expect_said(one, "is 80x120 pixels; expected 120x80 as in camera.yaml");
  // All of them: the camera's file is of another camera. Nothing can be shown, and it is said why.
  for (int i = 0; i < kPictures; ++i) {
    cv::imwrite((recording() / picture_file(i)).string(), cv::Mat(10, 10, CV_8UC3, cv::Scalar(0)));
  }
  const Replayed all = replay();
  EXPECT_EQ(all.run.status, 0) << all.run.err;
  EXPECT_EQ(all.summary["pictures_extracted"], 0);
  EXPECT_EQ(all.summary["pictures_unreadable"], kUsed);
  expect_said(all, "is 10x10 pixels; expected 120x80 as in camera.yaml");
}

TEST_F(BadInput, StampsOutOfOrderOrTwiceChangeNothing) {
  const Replayed sound = replay();
  std::vector<std::string> list = lines_of("rgb.txt"), poses = lines_of("groundtruth.txt");
  std::reverse(list.begin(), list.end());
  list.push_back(list[3]);
  std::swap(poses[1], poses[2]);
  poses.push_back(poses[0]);
  write_lines("rgb.txt", list);
  write_lines("groundtruth.txt", poses);
  const Replayed shuffled = replay();
  expect_good(shuffled);
  ASSERT_EQ(shuffled.pictures.size(), sound.pictures.size());
  for (std::size_t i = 0; i < sound.pictures.size(); ++i) {
    EXPECT_EQ(cv::norm(shuffled.pictures[i], sound.pictures[i], cv::NORM_INF), 0) << i;
  }
  expect_said(shuffled, "stamps out of order, sorted in; first ");
  expect_said(shuffled, "2 lines dropped, their stamp was there already; first ");
}

TEST_F(BadInput, PosesThatAreNoPoses) {
  std::vector<std::string> poses = lines_of("groundtruth.txt");
  const auto stamp = [&](std::size_t line) { return poses[line].substr(0, poses[line].find(' ')); };
  poses[1] = stamp(1) + " nan 0 0 0 0 0 1";
  poses[2] = stamp(2) + " 0 0 0 0 0 0 2";
  poses[4] = stamp(4) + " 0 0 inf 0 0 0 1";
  write_lines("groundtruth.txt", poses);
  // The camera moves evenly: its neighbours say as much as the lost poses did.
  const Replayed replayed = replay();
  expect_good(replayed);
  EXPECT_EQ(replayed.summary["items_damaged"], 3);
  expect_said(replayed, "2 poses dropped, not finite; first ");
  expect_said(replayed, "1 poses dropped, quaternion not of unit length; first ");
  for (std::string& pose : poses) pose = pose.substr(0, pose.find(' ')) + " 0 0 0 nan nan nan nan";
  write_lines("groundtruth.txt", poses);
  expect_refused("8 poses dropped, not finite");
}

TEST_F(BadInput, MeshWithEveryKindOfBadFace) {
  // In the wall's plane but beside it, so that the prediction stays what it was.
  std::vector<std::string> vertices{"nan 0 2", "5 0 2", "6 0 2", "6 1 2", "7 0 2", "5 0 3", "6 0 1"};
  std::vector<std::vector<int>> faces{{1, 2, 3},  // a corner that is not a number
                                      {2, 3, 5},  // no area
                                      {2, 3, 4},  // three faces on one edge
                                      {2, 3, 6},
                                      {3, 2, 7}};
  std::vector<int> round;
  for (int i = 0; i < 100; ++i) {
    const double angle = -2 * 3.14159265358979 * i / 100;
    vertices.push_back(std::to_string(9 + std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 2");
    round.push_back(static_cast<int>(vertices.size()));
  }
  faces.push_back(round);
  add_to_model(vertices, faces);
  const Replayed replayed = replay();
  expect_good(replayed);
  EXPECT_EQ(replayed.summary["polygons"], 24 + 3 + 1);
  expect_said(replayed, "2 of 30 faces are unusable and were dropped");
  const Finished inspect = run_foreview({"inspect", (recording() / "scene.obj").string()});
  EXPECT_EQ(inspect.status, 0) << inspect.err;
  for (const std::string line : {"faces dropped: no area            1\n", "faces dropped: not finite         1\n"}) {
    EXPECT_NE(inspect.out.find(line), std::string::npos) << inspect.out;
  }
}

TEST_F(BadInput, MeshOfNothingUsable) {
  write("scene.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  expect_refused("scene.obj: has no usable face");
  write("scene.obj", "v nan 0 0\nv 1 0 0\nv 2 1 0\nf 1 2 3\n");
  expect_refused("scene.obj: has no usable face");
}

TEST_F(BadInput, NoPolygonInView) {
  write("scene.obj", "v -1 -1 -5\nv 1 -1 -5\nv 1 1 -5\nv -1 1 -5\nf 1 2 3 4\n");
  const Replayed replayed = replay();
  ASSERT_EQ(replayed.run.status, 0) << replayed.run.err;
  EXPECT_EQ(replayed.summary["polygons_visible"], 0);
  EXPECT_EQ(replayed.summary["pictures_extracted"], kUsed);
  ASSERT_EQ(replayed.pictures.size(), std::size_t{kPictures});
  cv::Mat first;
  cv::extractChannel(replayed.pictures.back(), first, 0);
  EXPECT_EQ(cv::countNonZero(first != first.at<unsigned char>(0, 0)), 0) << "not one even background";
}

TEST_F(BadInput, CameraInsideAWallAndPolygonsAcrossItsPlane) {
  // A wall through the camera's path, another that contains the path itself, and a floor from behind to before it.
  add_to_model({"-9 -9 0", "9 -9 0", "9 9 0", "-9 9 0", "-9 0 -3", "9 0 -3", "9 0 1", "-9 0 1", "-9 0.6 -4", "9 0.6 -4",
                "9 0.6 1.9", "-9 0.6 1.9"},
               {{1, 2, 3, 4}, {4, 3, 2, 1}, {5, 6, 7, 8}, {8, 7, 6, 5}, {9, 10, 11, 12}, {12, 11, 10, 9}});
  const Replayed replayed = replay({"--edges", "--view", "both", "--wireframe"});
  ASSERT_EQ(replayed.run.status, 0) << replayed.run.err;
  EXPECT_EQ(replayed.pictures.size(), std::size_t{kPictures});
  EXPECT_GT(replayed.summary["polygons_visible"], kUsed);
}

TEST_F(BadInput, PicturesOfOnePixel) {
  fs::remove_all(recording());
  RecordingWriter::Description description;
  description.name = "pixel";
  description.cameras = {{"", test::pinhole(1, 1, 1)}};
  description.scene_file = "scene.obj";
  {
    RecordingWriter writer(recording(), description);
    write_obj(test::facing_rectangle(3, 2, 2), recording() / "scene.obj");
    for (int i = 0; i < kPictures; ++i) {
      writer.add_camera_pose(0, WallRecording::stamp(i), WallRecording::world_from_camera(i));
      writer.add_picture(0, WallRecording::stamp(i), cv::Mat(1, 1, CV_8UC3, cv::Scalar(30, 120, 210)), "png");
    }
    writer.finish();
  }
  const Replayed replayed = replay({"--view", "both"});
  ASSERT_EQ(replayed.run.status, 0) << replayed.run.err;
  ASSERT_EQ(replayed.pictures.size(), std::size_t{kPictures});
  ASSERT_EQ(replayed.pictures.back().size(), cv::Size(2, 1));
  // Not one texel has four valid pixels around it, so the prediction knows nothing; the delayed picture is as it was.
  EXPECT_EQ(replayed.pictures.back().at<cv::Vec3b>(0, 1), cv::Vec3b(30, 120, 210));
}

TEST_F(BadInput, TexturesLargerThanAnyDriverTakes) {
  expect_refused("--max-texels", {"--max-texels", "1000000"});
}

}  // namespace
}  // namespace foreview
