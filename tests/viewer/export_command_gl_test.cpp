#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <assimp/Importer.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/progress.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

/// A wall of two quads, the left one green and the right one blue in all of three pictures.
class ExportCommand : public ::testing::Test {
 protected:
  ExportCommand() {
    ProgressBar::set_quiet(true);
    RawMesh mesh;
    mesh.vertices = {{-0.5, -0.4, 2}, {0, -0.4, 2}, {0.5, -0.4, 2}, {-0.5, 0.4, 2}, {0, 0.4, 2}, {0.5, 0.4, 2}};
    mesh.faces = {{0, 3, 4, 1}, {1, 4, 5, 2}};
    RecordingWriter::Description description;
    description.name = "wall";
    description.cameras.resize(1);
    CameraModel& camera = description.cameras[0].model;
    camera.width = 120;
    camera.height = 100;
    camera.focal_length = {200, 200};
    camera.principal_point = {60, 50};
    description.scene_file = "scene.obj";
    description.import_options.merge_coplanar = false;
    RecordingWriter writer(files_ / "wall", description);
    write_obj(mesh, files_ / "wall/scene.obj");
    cv::Mat picture(100, 120, CV_8UC3, cv::Scalar(0, 255, 0));
    picture(cv::Rect(60, 0, 60, 100)).setTo(cv::Scalar(255, 0, 0));
    for (int i = 0; i < 3; ++i) {
      const Timestamp stamp = Timestamp::from_seconds(10 + 0.1 * i);
      writer.add_camera_pose(0, stamp, Pose{});
      writer.add_picture(0, stamp, picture, "png");
    }
    writer.finish();
  }

  void run(std::vector<std::string> arguments) const {
    CLI::App app;
    add_export_command(app);
    std::vector<std::string> reversed{"100", "--density", (files_ / "wall").string()};
    reversed.insert(reversed.end(), arguments.rbegin(), arguments.rend());
    reversed.emplace_back("export");
    app.parse(reversed);
  }

  test::TemporaryDirectory files_;
};

TEST_F(ExportCommand, WritesAModelThatShowsThePicturesColours) {
  run({files_ / "wall.glb", "--json", files_ / "wall.json"});
  const auto json = nlohmann::json::parse(files_.read("wall.json"));
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["polygons"], 2);
  EXPECT_EQ(json["polygons_seen"], 2);
  EXPECT_EQ(json["pictures"], 3);
  EXPECT_EQ(json["bytes"], files_.read("wall.glb").size());

  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile((files_ / "wall.glb").string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumTextures, 1U);
  const aiTexture& texture = *scene->mTextures[0];
  const cv::Mat page = cv::imdecode(
      cv::Mat(1, static_cast<int>(texture.mWidth), CV_8U, static_cast<void*>(texture.pcData)), cv::IMREAD_COLOR);
  ASSERT_EQ(scene->mNumMeshes, 1U);
  const aiMesh& mesh = *scene->mMeshes[0];
  ASSERT_EQ(mesh.mNumFaces, 4U);
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    aiVector3D centre, uv;
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned index = mesh.mFaces[f].mIndices[k];
      centre += mesh.mVertices[index] / 3.0F;
      uv += mesh.mTextureCoords[0][index] / 3.0F;
    }
    const auto bgr = page.at<cv::Vec3b>(static_cast<int>((1 - uv.y) * static_cast<float>(page.rows)),
                                        static_cast<int>(uv.x * static_cast<float>(page.cols)));
    EXPECT_EQ(bgr, centre.x < 0 ? cv::Vec3b(0, 255, 0) : cv::Vec3b(255, 0, 0)) << "triangle " << f;
  }
}

TEST_F(ExportCommand, UsesPicturesUpToAndWithTheLastOfTheRange) {
  run({files_ / "wall.glb", "--json", files_ / "wall.json", "--to", "#1"});
  EXPECT_EQ(nlohmann::json::parse(files_.read("wall.json"))["pictures"], 2);
  run({files_ / "wall.glb", "--json", files_ / "wall.json", "--delay", "100ms"});
  EXPECT_EQ(nlohmann::json::parse(files_.read("wall.json"))["pictures"], 2);
}

TEST_F(ExportCommand, RefusesWhatItCannotWriteBeforeTheLongWork) {
  EXPECT_THROW(run({files_ / "wall.obj"}), InputError);
  EXPECT_THROW(run({files_ / "nowhere/wall.glb"}), InputError);
  EXPECT_THROW(run({files_ / "wall.glb", "--json", files_ / "nowhere/wall.json"}), InputError);
  EXPECT_THROW(run({files_ / "wall.glb", "--to", "#7"}), InputError);
}

}  // namespace
}  // namespace foreview
