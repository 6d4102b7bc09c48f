#include "foreview/recordings/picture_file.h"

#include <gtest/gtest.h>

#include "sample_recording.h"

namespace foreview {
namespace {

using test::encoded;
using test::patterned_picture;

cv::Mat decode(const std::string& bytes, std::optional<cv::Size> expected = std::nullopt) {
  return decode_picture({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, "picture", expected);
}

std::string error_of(const std::string& bytes, std::optional<cv::Size> expected = std::nullopt) {
  try {
    static_cast<void>(decode(bytes, expected));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(PictureFile, PngIsReadBitForBit) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(33, 7), cv::Size(640, 480)}) {
    const cv::Mat picture = patterned_picture(size.width, size.height, 5);
    EXPECT_TRUE(equal(decode(encoded(picture, ".png"), size), picture)) << size;
  }
}

TEST(PictureFile, EveryKindOfJpegIsRead) {
  const cv::Mat picture = patterned_picture(61, 45, 5);
  for (const std::vector<int>& options :
       {std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 95}, std::vector<int>{cv::IMWRITE_JPEG_PROGRESSIVE, 1},
        std::vector<int>{cv::IMWRITE_JPEG_RST_INTERVAL, 2}, std::vector<int>{cv::IMWRITE_JPEG_OPTIMIZE, 1}}) {
    const std::string bytes = encoded(picture, ".jpg", options);
    const std::vector<unsigned char> buffer(bytes.begin(), bytes.end());
    EXPECT_TRUE(equal(decode(bytes), cv::imdecode(buffer, cv::IMREAD_COLOR)));
  }
}

TEST(PictureFile, GreyAlphaAndSixteenBitsBecomeBgr) {
  const cv::Mat grey(5, 4, CV_8UC1, cv::Scalar(77));
  for (const char* ending : {".png", ".jpg"}) {
    EXPECT_TRUE(equal(decode(encoded(grey, ending)), cv::Mat(5, 4, CV_8UC3, cv::Scalar(77, 77, 77)))) << ending;
  }
  const cv::Mat clear(5, 4, CV_8UC4, cv::Scalar(10, 20, 30, 0));
  EXPECT_TRUE(equal(decode(encoded(clear, ".png")), cv::Mat(5, 4, CV_8UC3, cv::Scalar(10, 20, 30))));
  const cv::Mat deep(5, 4, CV_16UC3, cv::Scalar(0x1010, 0x2020, 0x3030));
  EXPECT_TRUE(equal(decode(encoded(deep, ".png")), cv::Mat(5, 4, CV_8UC3, cv::Scalar(0x10, 0x20, 0x30))));
}

TEST(PictureFile, CutOffAnywhereIsRefused) {
  const cv::Mat picture = patterned_picture(40, 30, 9);
  for (const std::string& whole :
       {encoded(picture, ".png"), encoded(picture, ".jpg"), encoded(picture, ".jpg", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
        encoded(picture, ".jpg", {cv::IMWRITE_JPEG_RST_INTERVAL, 1})}) {
    ASSERT_EQ(error_of(whole), "");
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_NE(error_of(whole.substr(0, length)), "") << length << " of " << whole.size();
    }
    // What a full disk or a lost connection leaves where the length was reserved before.
    std::string zeros = whole;
    std::fill(zeros.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2), zeros.end(), '\0');
    EXPECT_NE(error_of(zeros), "");
    EXPECT_EQ(error_of(whole + std::string(100, '\0')), "");  // padding after a whole picture does no harm
  }
  EXPECT_EQ(error_of(encoded(picture, ".jpg").substr(0, 500)), "picture: is a JPEG that is cut off");
  EXPECT_EQ(error_of(encoded(picture, ".png").substr(0, 100)), "picture: is a PNG that is cut off");
}

TEST(PictureFile, EndMarkOfAnEmbeddedThumbnailIsNotTheEnd) {
  const std::string jpeg = encoded(patterned_picture(40, 30, 9), ".jpg");
  const std::string thumbnail = encoded(patterned_picture(8, 8, 1), ".jpg");
  const std::size_t length = thumbnail.size() + 2;
  std::string segment = "\xff\xe5";
  segment += static_cast<char>(length >> 8);
  segment += static_cast<char>(length & 0xff);
  const std::string whole = jpeg.substr(0, 2) + segment + thumbnail + jpeg.substr(2);
  EXPECT_EQ(error_of(whole), "");
  EXPECT_NE(error_of(whole.substr(0, whole.size() - 100)), "");
}

TEST(PictureFile, AFlippedBitOfAPngIsRefused) {
  const std::string whole = encoded(patterned_picture(40, 30, 9), ".png");
  for (std::size_t at = 8; at < whole.size(); at += 7) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    EXPECT_NE(error_of(damaged), "") << at;
  }
}

TEST(PictureFile, SizesThatAHeaderClaimsAreCheckedBeforeDecoding) {
  std::string jpeg = encoded(patterned_picture(40, 30, 9), ".jpg");
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (std::size_t i = 5; i < 9; ++i) jpeg[frame + i] = static_cast<char>(0xff);
  EXPECT_EQ(error_of(jpeg), "picture: is 65535x65535 pixels; more than are accepted");
  EXPECT_EQ(error_of(jpeg, cv::Size(40, 30)), "picture: is 65535x65535 pixels; expected 40x30 as in camera.yaml");
  EXPECT_EQ(error_of(encoded(patterned_picture(1, 1, 0), ".png"), cv::Size(40, 30)),
            "picture: is 1x1 pixels; expected 40x30 as in camera.yaml");
  EXPECT_EQ(error_of(encoded(patterned_picture(30, 40, 0), ".png"), cv::Size(40, 30)),
            "picture: is 30x40 pixels; expected 40x30 as in camera.yaml");
}

TEST(PictureFile, OtherFilesAreRefused) {
  const cv::Mat picture = patterned_picture(4, 4, 0);
  EXPECT_EQ(error_of(""), "picture: is empty; expected a JPEG or PNG picture");
  for (const std::string& bytes :
       {std::string("hello"), std::string("\xff\xd8\xff", 3), std::string("\xff\xd8\xff\xd9", 4),
        std::string("\x89PNG\r\n\x1a\n", 8), std::string(1000, '\xff'), encoded(picture, ".bmp"),
        std::string("\xff\xd8\xff\xe0\x00\x00", 6), std::string("\xff\xd8\xff\xd0\xff\xd9", 6)}) {
    EXPECT_EQ(error_of(bytes).find("picture: "), 0U) << error_of(bytes);
  }
}

TEST(PictureFile, IsReadFromDiskAndNamed) {
  const test::TemporaryDirectory directory;
  const cv::Mat picture = patterned_picture(9, 8, 2);
  EXPECT_TRUE(equal(read_picture_file(directory.write("a.png", encoded(picture, ".png"))), picture));
  for (const std::filesystem::path& file : {directory / "none.png", directory.path(), directory.write("empty.png", ""),
                                            std::filesystem::path("/dev/zero")}) {
    try {
      static_cast<void>(read_picture_file(file));
      ADD_FAILURE() << file;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find(file.string() + ": "), 0U) << error.what();
    }
  }
}

}  // namespace
}  // namespace foreview
