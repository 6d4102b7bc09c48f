#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "foreview/gpu/texture_store.h"
#include "gpu/gl_test_fixture.h"
#include "gpu/test_model.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

using nlohmann::json;
using State = TextureStore::PolygonState;

/// Two parts (five and two quads); charts on two pages, each of one colour; polygons 2 and 6 never seen.
class ExportedGlb : public GlTest {
 protected:
  ExportedGlb() {
    pages_ = {cv::Mat(64, 64, CV_8UC4, cv::Scalar(1, 2, 3, 0)), cv::Mat(64, 64, CV_8UC4, cv::Scalar(1, 2, 3, 0))};
    for (std::size_t i = 0; i < 7; ++i) {
      const Chart& chart = store_.layout().charts[i];
      pages_[chart.page](cv::Rect(chart.origin.x, chart.origin.y, chart.size.x, chart.size.y)).setTo(colour_of(i));
      const bool seen = i != 2 && i != 6;
      states_.push_back({0.8F, 0.5F, 0.02F, seen ? 1.0F : 0.5F});
    }
    store_.write_pages(pages_, states_);
    poses_.resize(2);
    poses_[1].rotation = glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3)));
    poses_[1].translation = {0.3, -2, 5};
    file_ = files_ / "model.glb";
    export_glb(store_, poses_, file_);
  }
  static cv::Scalar colour_of(std::size_t i) {
    return {30.0 * static_cast<double>(i), 200, 255 - 30.0 * static_cast<double>(i), 255};
  }

  test::TemporaryDirectory files_;
  std::filesystem::path file_;
  PolygonModel model_ = rows_of_quads({5, 2});
  TextureStore store_{model_, tight_layout(model_, {{32, 32}, {16, 32}}, 64)};
  std::vector<cv::Mat> pages_;
  std::vector<State> states_;
  std::vector<Pose> poses_;
};

/// Every triangle of a scene with its corners in the scene's root frame and the colour shown at its centre.
struct SeenTriangle {
  glm::dvec3 corners[3];
  cv::Vec3d bgr;
  bool textured = false;
};

void collect(const aiScene& scene, const std::vector<cv::Mat>& pictures, const aiNode& node, const aiMatrix4x4& parent,
             std::vector<SeenTriangle>& triangles) {
  const aiMatrix4x4 root_from_node = parent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    aiString texture;
    const bool textured =
        scene.mMaterials[mesh.mMaterialIndex]->GetTexture(aiTextureType_DIFFUSE, 0, &texture) == aiReturn_SUCCESS;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      ASSERT_EQ(mesh.mFaces[f].mNumIndices, 3U);
      SeenTriangle triangle;
      triangle.textured = textured;
      cv::Vec2d uv(0, 0);
      for (unsigned k = 0; k < 3; ++k) {
        const unsigned index = mesh.mFaces[f].mIndices[k];
        const aiVector3D p = root_from_node * mesh.mVertices[index];
        triangle.corners[k] = {p.x, p.y, p.z};
        if (textured) {
          // assimp turns v over on import.
          uv += cv::Vec2d(mesh.mTextureCoords[0][index].x, 1.0 - mesh.mTextureCoords[0][index].y) / 3.0;
        } else {
          const aiColor4D c = mesh.mColors[0][index];
          triangle.bgr += cv::Vec3d(c.b, c.g, c.r) / 3.0;
        }
      }
      if (textured) {
        const cv::Mat& picture = pictures.at(static_cast<std::size_t>(std::stoi(texture.C_Str() + 1)));
        const auto bgr =
            picture.at<cv::Vec3b>(static_cast<int>(uv[1] * picture.rows), static_cast<int>(uv[0] * picture.cols));
        triangle.bgr = cv::Vec3d(bgr[0], bgr[1], bgr[2]);
      }
      triangles.push_back(triangle);
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    collect(scene, pictures, *node.mChildren[c], root_from_node, triangles);
  }
}

TEST_F(ExportedGlb, ShowsEveryPolygonInPlaceAndColourToAssimp) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file_.string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  std::vector<cv::Mat> pictures;
  for (unsigned i = 0; i < scene->mNumTextures; ++i) {
    const aiTexture& texture = *scene->mTextures[i];
    ASSERT_EQ(texture.mHeight, 0U) << "compressed";
    pictures.push_back(cv::imdecode(
        cv::Mat(1, static_cast<int>(texture.mWidth), CV_8U, static_cast<void*>(texture.pcData)), cv::IMREAD_UNCHANGED));
    ASSERT_EQ(pictures.back().type(), CV_8UC3) << "without provenance, which a viewer would take for transparency";
  }
  ASSERT_EQ(pictures.size(), 2U);
  EXPECT_EQ(pictures[0].size(), cv::Size(48, 64)) << "cut to what is used";
  std::vector<SeenTriangle> triangles;
  collect(*scene, pictures, *scene->mRootNode, aiMatrix4x4(), triangles);
  ASSERT_EQ(triangles.size(), 14U);

  for (std::size_t i = 0; i < 7; ++i) {
    const Polygon& polygon = model_.polygons()[i];
    std::size_t found = 0;
    for (const SeenTriangle& triangle : triangles) {
      bool is_of_this = true;
      for (const glm::dvec3& at : triangle.corners) {
        bool is_corner = false;
        for (std::size_t k = 0; k < 4; ++k) {
          const glm::dvec3 world = poses_[polygon.part] * model_.corner(i, k);
          is_corner = is_corner || glm::distance(at, glm::dvec3(world.x, world.z, -world.y)) < 1e-5;
        }
        is_of_this = is_of_this && is_corner;
      }
      if (!is_of_this) continue;
      ++found;
      const glm::dvec3 normal = glm::normalize(
          glm::cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]));
      const glm::dvec3 expected = poses_[polygon.part].rotate({0, 0, 1});
      EXPECT_LT(glm::distance(normal, glm::dvec3(expected.x, expected.z, -expected.y)), 1e-5) << "front is outside";
      const bool seen = i != 2 && i != 6;
      EXPECT_EQ(triangle.textured, seen);
      if (seen) {
        for (int c = 0; c < 3; ++c) EXPECT_EQ(triangle.bgr[c], colour_of(i)[c]) << i;
      } else {
        // sRGB 0.8, 0.5, 0.02 in linear light (IEC 61966-2-1).
        EXPECT_NEAR(triangle.bgr[2], 0.603827, 1e-5);
        EXPECT_NEAR(triangle.bgr[1], 0.214041, 1e-5);
        EXPECT_NEAR(triangle.bgr[0], 0.001548, 1e-5);
      }
    }
    EXPECT_EQ(found, 2U) << "triangles of polygon " << i;
  }
}

TEST_F(ExportedGlb, KeepsTheRulesOfTheSpecification) {
  const std::string glb = files_.read("model.glb");
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, glb.data() + at, 4);
    return static_cast<std::size_t>(value);
  };
  ASSERT_GT(glb.size(), 20U);
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(word(4), 2U);
  EXPECT_EQ(word(8), glb.size());
  const std::size_t json_length = word(12);
  EXPECT_EQ(glb.substr(16, 4), "JSON");
  EXPECT_EQ(json_length % 4, 0U);
  const std::size_t binary_length = word(20 + json_length);
  EXPECT_EQ(glb.substr(24 + json_length, 4), std::string("BIN\0", 4));
  EXPECT_EQ(binary_length % 4, 0U);
  EXPECT_EQ(28 + json_length + binary_length, glb.size());
  const char* binary = glb.data() + 28 + json_length;

  const json document = json::parse(glb.substr(20, json_length));
  EXPECT_EQ(document["asset"]["version"], "2.0");
  ASSERT_EQ(document["buffers"].size(), 1U);
  EXPECT_EQ(document["buffers"][0]["byteLength"], binary_length);
  for (const json& view : document["bufferViews"]) {
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(), binary_length);
  }
  for (const json& accessor : document["accessors"]) {
    const json& view = document["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0U);
    const std::string type = accessor["type"];
    const std::size_t components = type == "SCALAR" ? 1 : type == "VEC2" ? 2 : 3;
    EXPECT_EQ(view["byteLength"].get<std::size_t>(), accessor["count"].get<std::size_t>() * components * 4);
  }
  std::size_t primitives = 0;
  for (const json& mesh : document["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      ++primitives;
      const json& position = document["accessors"].at(primitive["attributes"]["POSITION"].get<std::size_t>());
      const json& indices = document["accessors"].at(primitive["indices"].get<std::size_t>());
      const auto count = position["count"].get<std::size_t>();
      const char* data =
          binary + document["bufferViews"][position["bufferView"].get<std::size_t>()]["byteOffset"].get<std::size_t>();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float least = INFINITY, greatest = -INFINITY;
        for (std::size_t i = 0; i < count; ++i) {
          float value = 0;
          std::memcpy(&value, data + 12 * i + 4 * axis, 4);
          least = std::min(least, value);
          greatest = std::max(greatest, value);
        }
        EXPECT_EQ(position["min"][axis].get<float>(), least);
        EXPECT_EQ(position["max"][axis].get<float>(), greatest);
      }
      for (const auto& [name, accessor] : primitive["attributes"].items()) {
        EXPECT_EQ(document["accessors"].at(accessor.get<std::size_t>())["count"].get<std::size_t>(), count) << name;
      }
      const char* index_data =
          binary + document["bufferViews"][indices["bufferView"].get<std::size_t>()]["byteOffset"].get<std::size_t>();
      for (std::size_t i = 0; i < indices["count"].get<std::size_t>(); ++i) {
        std::uint32_t index = 0;
        std::memcpy(&index, index_data + 4 * i, 4);
        EXPECT_LT(index, count);
      }
      const json& material = document["materials"].at(primitive["material"].get<std::size_t>());
      EXPECT_TRUE(material["extensions"].contains("KHR_materials_unlit"));
    }
  }
  EXPECT_EQ(primitives, 5U) << "two pages and never seen in one part, one page and never seen in the other";
}

TEST_F(ExportedGlb, OfNothingSeenHasColoursOnly) {
  store_.clear();
  export_glb(store_, poses_, file_);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file_.string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  EXPECT_EQ(scene->mNumTextures, 0U);
  EXPECT_EQ(scene->mNumMeshes, 2U);
}

TEST_F(ExportedGlb, CannotGoWhereNoDirectoryIs) {
  try {
    export_glb(store_, poses_, files_ / "nowhere" / "model.glb");
    FAIL() << "written";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("model.glb"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace foreview
