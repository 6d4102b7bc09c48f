#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "foreview/gpu/texture_store.h"
#include "foreview/gpu/textures_format.h"
#include "gpu/gl_test_fixture.h"
#include "gpu/test_model.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using State = TextureStore::PolygonState;

class SavedTextures : public GlTest {
 protected:
  SavedTextures() {
    pages_ = {cv::Mat(64, 64, CV_8UC4), cv::Mat(64, 64, CV_8UC4)};
    cv::RNG random(11);
    for (cv::Mat& page : pages_) random.fill(page, cv::RNG::UNIFORM, 0, 256);
    for (int i = 0; i < 6; ++i) states_.push_back({0.1F * static_cast<float>(i), 1.0F / 3, 0.7F, i < 3 ? 1.0F : 0.5F});
    store_.write_pages(pages_, states_);
    directory_ = files_ / "saved";
    save_textures(store_, directory_);
  }

  void write_index(const std::function<void(TexturesIndex&)>& change) const {
    TexturesIndex index = parse_textures_yaml(files_.read("saved/textures.yaml"), "textures.yaml");
    change(index);
    (void)files_.write("saved/textures.yaml", to_textures_yaml(index));
  }
  /// Loading must fail with this text in its message, and leave the store as it was.
  void expect_refusal(const std::string& expected, TextureStore& store) const {
    const cv::Mat before = store.read_pages()[0];
    try {
      load_textures(store, directory_);
      ADD_FAILURE() << "loaded; expected: " << expected;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
    EXPECT_EQ(cv::norm(store.read_pages()[0], before, cv::NORM_INF), 0);
  }
  void expect_refusal(const std::string& expected) { expect_refusal(expected, store_); }

  test::TemporaryDirectory files_;
  fs::path directory_;
  PolygonModel model_ = rows_of_quads({6});
  TextureStore store_{model_, tight_layout(model_, {{32, 32}}, 64)};
  std::vector<cv::Mat> pages_;
  std::vector<State> states_;
};

TEST_F(SavedTextures, ComeBackBitByBit) {
  TextureStore other(model_, store_.layout());
  load_textures(other, directory_);
  const std::vector<cv::Mat> read = other.read_pages();
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(cv::norm(read[i], pages_[i], cv::NORM_INF), 0);
  const std::vector<State> states = other.read_polygon_states();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    EXPECT_EQ(states[i].red, states_[i].red);
    EXPECT_EQ(states[i].green, states_[i].green);
    EXPECT_EQ(states[i].blue, states_[i].blue);
    EXPECT_EQ(states[i].seen, states_[i].seen);
  }
  // Levels are rebuilt, not only the base.
  cv::Mat coarse(4, 4, CV_8UC4);
  glGetTextureSubImage(other.pages(), 4, 0, 0, 0, 4, 4, 1, GL_BGRA, GL_UNSIGNED_BYTE, 64, coarse.data);
  EXPECT_NEAR(coarse.at<cv::Vec4b>(0, 0)[1], cv::mean(pages_[0](cv::Rect(0, 0, 16, 16)))[1], 0.51);
}

TEST_F(SavedTextures, AreReplacedWithoutTouchingOtherFiles) {
  (void)files_.write("saved/notes.txt", "mine");
  (void)files_.write("saved/page-002.png", "of a larger set");
  store_.clear();
  save_textures(store_, directory_);
  EXPECT_EQ(files_.read("saved/notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(directory_ / "page-002.png"));
  for (const auto& entry : fs::directory_iterator(directory_)) EXPECT_NE(entry.path().extension(), ".new");
  store_.write_pages(pages_, states_);
  load_textures(store_, directory_);
  EXPECT_EQ(store_.count_observed_texels(), 0U);
}

TEST_F(SavedTextures, OfAnotherModelAreRefused) {
  const PolygonModel other_model = rows_of_quads({5});
  TextureStore other(other_model, tight_layout(other_model, {{32, 32}}, 64));
  expect_refusal("belong to another model", other);
}

TEST_F(SavedTextures, OfAnotherLayoutAreRefused) {
  TextureStore other(model_, tight_layout(model_, {{16, 32}}, 64));
  expect_refusal("--density", other);
}

TEST_F(SavedTextures, OfPolygonsGroupedOtherwiseAreRefused) {
  ChartOptions options;
  options.texels_per_metre = 200;
  const ChartLayout grouped = lay_out_charts(model_, options);
  ASSERT_EQ(grouped.groups.size(), 1U);
  TextureStore other(model_, grouped);
  expect_refusal("these textures lie in 6 charts, but here the polygons share 1; use the same --pipeline", other);
}

TEST_F(SavedTextures, WithMissingFilesAreRefused) {
  fs::remove(directory_ / "page-001.png");
  expect_refusal("page-001.png: no such file");
  fs::remove(directory_ / "polygon-states.csv");
  expect_refusal("polygon-states.csv: no such file");
  fs::remove(directory_ / "textures.yaml");
  expect_refusal("textures.yaml: no such file");
  fs::remove_all(directory_);
  expect_refusal("is no directory");
  (void)files_.write("saved", "a file");
  expect_refusal("is no directory");
}

TEST_F(SavedTextures, WithDamagedFilesAreRefused) {
  const std::string page = files_.read("saved/page-000.png");
  (void)files_.write("saved/page-000.png", page.substr(0, page.size() / 2));
  expect_refusal("page-000.png: is damaged");
  std::string flipped = page;
  flipped[page.size() / 2] = static_cast<char>(flipped[page.size() / 2] ^ 1);
  (void)files_.write("saved/page-000.png", flipped);
  expect_refusal("page-000.png: is damaged");
  (void)files_.write("saved/page-000.png", std::string(200000, 'x'));
  expect_refusal("page-000.png: is larger");
  (void)files_.write("saved/page-000.png", page);
  std::string states = files_.read("saved/polygon-states.csv");
  (void)files_.write("saved/polygon-states.csv", states + "0,0,0,1\n");
  expect_refusal("polygon-states.csv: is damaged");
}

TEST_F(SavedTextures, ThatAreConsistentButWrongAreRefused) {
  const auto put_page = [&](const std::string& bytes) {
    (void)files_.write("saved/page-000.png", bytes);
    write_index([&](TexturesIndex& index) { index.page_checksums[0] = file_checksum(bytes); });
  };
  const auto png = [](const cv::Mat& picture) {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture, bytes);
    return std::string(bytes.begin(), bytes.end());
  };
  put_page("not a PNG");
  expect_refusal("page-000.png: is something else; expected an RGBA PNG of 64 x 64");
  put_page(png(cv::Mat(64, 64, CV_8UC3, cv::Scalar(1, 2, 3))));
  expect_refusal("page-000.png: is something else");
  put_page(png(cv::Mat(32, 64, CV_8UC4, cv::Scalar(1, 2, 3))));
  expect_refusal("page-000.png: is of 64 x 32");
  const std::string cut = png(pages_[0]);
  put_page(cut.substr(0, 60));
  expect_refusal("page-000.png: cannot be decoded");
  // A header that claims 65535 x 65535 pixels must not make anyone allocate them.
  std::string huge = cut;
  huge[18] = huge[19] = huge[22] = huge[23] = '\xff';
  put_page(huge);
  expect_refusal("page-000.png: is of 65535 x 65535");
  put_page(cut);
  write_index([](TexturesIndex& index) { index.page_checksums.pop_back(); });
  expect_refusal("its figures contradict");
}

TEST_F(SavedTextures, CannotGoWhereAFileIs) {
  (void)files_.write("taken", "a file");
  EXPECT_THROW(save_textures(store_, files_ / "taken"), InputError);
  EXPECT_THROW(save_textures(store_, files_ / "taken/below"), InputError);
}

}  // namespace
}  // namespace foreview
