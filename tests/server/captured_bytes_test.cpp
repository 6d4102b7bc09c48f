#include "foreview/server/capture/captured_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "foreview/recordings/picture_file.h"

namespace foreview {
namespace {

using Bytes = std::vector<unsigned char>;

VideoFormat jpeg_format(int width, int height) {
  return {.mode = {.format = CaptureFormat::mjpeg, .width = width, .height = height}};
}

cv::Mat colourful(int width, int height) {
  cv::Mat picture(height, width, CV_8UC3);
  std::mt19937 random(5);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<unsigned char>(3 * x), static_cast<unsigned char>(5 * y),
                                              static_cast<unsigned char>(random() % 64));
    }
  }
  return picture;
}

Bytes encode(const cv::Mat& picture, const std::vector<int>& options = {}) {
  Bytes bytes;
  cv::imencode(".jpg", picture, bytes, options);
  return bytes;
}

/// Begin of each segment up to and including the scan's.
std::vector<std::size_t> segments_of(const Bytes& jpeg) {
  std::vector<std::size_t> segments;
  for (std::size_t at = 2;; at += 2 + (std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3])) {
    segments.push_back(at);
    if (jpeg[at + 1] == 0xda) return segments;
  }
}

Bytes without_tables(const Bytes& jpeg) {
  Bytes result(jpeg.begin(), jpeg.begin() + 2);
  const std::vector<std::size_t> segments = segments_of(jpeg);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (jpeg[segments[i] + 1] == 0xc4) continue;
    const std::size_t end = i + 1 < segments.size() ? segments[i + 1] : jpeg.size();
    result.insert(result.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(segments[i]),
                  jpeg.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return result;
}

std::size_t tables_in(const Bytes& jpeg) {
  const std::vector<std::size_t> segments = segments_of(jpeg);
  return static_cast<std::size_t>(
      std::count_if(segments.begin(), segments.end(), [&](std::size_t at) { return jpeg[at + 1] == 0xc4; }));
}

TEST(CapturedBytes, AWholeJpegIsPassedOnAsItIs) {
  const Bytes jpeg = encode(colourful(48, 32));
  Bytes picture;
  EXPECT_EQ(read_captured(jpeg_format(48, 32), jpeg, picture), CaptureFault::none);
  EXPECT_EQ(picture, jpeg);
}

TEST(CapturedBytes, MissingHuffmanTablesArePutIn) {
  const Bytes jpeg = encode(colourful(48, 32));
  const Bytes bare = without_tables(jpeg);
  ASSERT_EQ(tables_in(bare), 0u);
  Bytes picture;
  ASSERT_EQ(read_captured(jpeg_format(48, 32), bare, picture), CaptureFault::none);
  EXPECT_EQ(tables_in(picture), 1u);
  EXPECT_EQ(picture.size(), bare.size() + 420);
  const cv::Mat expected = decode_picture(jpeg, "original"), found = decode_picture(picture, "repaired");
  EXPECT_EQ(cv::norm(expected, found, cv::NORM_INF), 0);

  // That decoder might have known the tables by itself; so, table by table, against what an encoder wrote.
  Bytes standard;
  for (const std::size_t at : segments_of(jpeg)) {
    if (jpeg[at + 1] != 0xc4) continue;
    const std::size_t length = std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3];
    standard.insert(standard.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at + 4),
                    jpeg.begin() + static_cast<std::ptrdiff_t>(at + 2 + length));
  }
  const std::vector<std::size_t> segments = segments_of(picture);
  const std::size_t at = segments[segments.size() - 2];
  ASSERT_EQ(picture[at + 1], 0xc4);
  EXPECT_EQ(Bytes(picture.begin() + static_cast<std::ptrdiff_t>(at + 4),
                  picture.begin() + static_cast<std::ptrdiff_t>(segments.back())),
            standard);
}

TEST(CapturedBytes, TablesOfItsOwnAreKept) {
  const Bytes jpeg = encode(colourful(48, 32), {cv::IMWRITE_JPEG_OPTIMIZE, 1});
  Bytes picture;
  ASSERT_EQ(read_captured(jpeg_format(48, 32), jpeg, picture), CaptureFault::none);
  EXPECT_EQ(picture, jpeg);
}

TEST(CapturedBytes, WhatCamerasAppendIsCutOff) {
  const Bytes jpeg = encode(colourful(48, 32), {cv::IMWRITE_JPEG_RST_INTERVAL, 1});
  Bytes padded = jpeg;
  padded.resize(jpeg.size() + 1000, 0);
  Bytes picture;
  ASSERT_EQ(read_captured(jpeg_format(48, 32), padded, picture), CaptureFault::none);
  EXPECT_EQ(picture, jpeg);
}

TEST(CapturedBytes, EveryCutIsShort) {
  const Bytes jpeg = encode(colourful(48, 32));
  Bytes picture;
  for (std::size_t length = 0; length < jpeg.size(); ++length) {
    ASSERT_EQ(read_captured(jpeg_format(48, 32), {jpeg.data(), length}, picture), CaptureFault::short_frame) << length;
  }
}

TEST(CapturedBytes, WrongSizesAndWhatIsNoJpegAreToldApart) {
  const Bytes jpeg = encode(colourful(48, 32));
  Bytes picture;
  EXPECT_EQ(read_captured(jpeg_format(32, 48), jpeg, picture), CaptureFault::wrong_size);
  EXPECT_EQ(read_captured(jpeg_format(48, 33), jpeg, picture), CaptureFault::wrong_size);
  EXPECT_EQ(read_captured(jpeg_format(48, 32), Bytes(500, 0), picture), CaptureFault::damaged);
  EXPECT_EQ(read_captured(jpeg_format(48, 32), Bytes{0xff, 0xd8, 0xff, 0xd9}, picture), CaptureFault::damaged);
  Bytes broken = jpeg;
  broken[segments_of(jpeg)[1]] = 0x12;
  EXPECT_EQ(read_captured(jpeg_format(48, 32), broken, picture), CaptureFault::damaged);
  broken = jpeg;
  broken[segments_of(jpeg)[1] + 2] = broken[segments_of(jpeg)[1] + 3] = 0;
  EXPECT_EQ(read_captured(jpeg_format(48, 32), broken, picture), CaptureFault::damaged);
  const Bytes lossless{0xff, 0xd8, 0xff, 0xc3, 0, 11, 8, 0, 32, 0, 48, 1, 1, 0x11, 0};
  EXPECT_EQ(read_captured(jpeg_format(48, 32), lossless, picture), CaptureFault::damaged);
}

TEST(CapturedBytes, RawRowsLoseTheirPaddingAndTheLastMayHaveNone) {
  const VideoFormat format{
      .mode = {.format = CaptureFormat::grey, .width = 3, .height = 2}, .bytes_per_line = 5, .size_image = 12};
  Bytes bytes(13);
  std::iota(bytes.begin(), bytes.end(), static_cast<unsigned char>(0));
  Bytes picture;
  for (const std::size_t length : {8, 10, 12}) {
    ASSERT_EQ(read_captured(format, {bytes.data(), length}, picture), CaptureFault::none) << length;
    EXPECT_EQ(picture, (Bytes{0, 1, 2, 5, 6, 7}));
  }
  EXPECT_EQ(read_captured(format, {bytes.data(), 7}, picture), CaptureFault::short_frame);
  EXPECT_EQ(read_captured(format, {}, picture), CaptureFault::short_frame);
  EXPECT_EQ(read_captured(format, bytes, picture), CaptureFault::wrong_size);
}

}  // namespace
}  // namespace foreview
