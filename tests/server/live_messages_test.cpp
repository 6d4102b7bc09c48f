#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "foreview/scene/errors.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/encoded_picture.h"

namespace foreview {
namespace {

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& failure) {
    return failure.what();
  }
  return "";
}

CameraModel lens(DistortionModel model, std::initializer_list<double> coefficients) {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.focal_length = {500, 501};
  camera.principal_point = {321.25, 239.5};
  camera.distortion_model = model;
  std::copy(coefficients.begin(), coefficients.end(), camera.distortion.begin());
  return camera;
}

TEST(CameraInfo, EveryModelComesBackAsItWasSent) {
  for (const CameraModel& camera :
       {lens(DistortionModel::none, {}), lens(DistortionModel::plumb_bob, {0.1, -0.2, 0.003, 0.004, 0.05}),
        lens(DistortionModel::plumb_bob, {0.1, -0.2, 0.003, 0.004, 0.05, 0.6, 0.07, 0.08}),
        lens(DistortionModel::fisheye, {0.1, 0.2, 0.3, 0.4})}) {
    const CameraModel back = camera_from_info(info_from_camera(camera), "topic");
    EXPECT_EQ(back.width, camera.width);
    EXPECT_EQ(back.height, camera.height);
    EXPECT_EQ(back.focal_length, camera.focal_length);
    EXPECT_EQ(back.principal_point, camera.principal_point);
    EXPECT_EQ(back.distortion_model, camera.distortion_model);
    EXPECT_EQ(back.distortion, camera.distortion);
  }
}

TEST(CameraInfo, RegionAndBinningAreWorkedIn) {
  CameraInfoMessage info = info_from_camera(lens(DistortionModel::none, {}));
  info.roi = {100, 40, 200, 320};
  info.binning_x = info.binning_y = 2;
  const CameraModel camera = camera_from_info(info, "topic");
  EXPECT_EQ(camera.width, 160);
  EXPECT_EQ(camera.height, 100);
  // The point that was on pixel (321.25, 239.5) of the whole picture.
  EXPECT_EQ(camera.principal_point, glm::dvec2((321.25 - 100) / 2, (239.5 - 40) / 2));
  EXPECT_EQ(camera.focal_length, glm::dvec2(250, 250.5));
}

TEST(CameraInfo, RefusesWhatCannotBe) {
  const auto error = [](const std::function<void(CameraInfoMessage&)>& change) {
    CameraInfoMessage info = info_from_camera(lens(DistortionModel::plumb_bob, {0.1}));
    change(info);
    return error_of([&] { static_cast<void>(camera_from_info(info, "camera_info")); });
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_NE(error([](auto& i) { i.width = 0; }).find("expected 1 to 16384"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.height = 4'000'000'000; }).find("expected 1 to 16384"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.k = {}; }).find("not calibrated"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.k[4] = std::nan(""); }).find("focal lengths"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.k[0] = 5e-324, i.binning_x = 2; }).find("focal lengths"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.k[1] = 1; }).find("fx, 0, cx"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.k[2] = std::nan(""); }).find("principal point"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.d = {1, 2}; }).find("expected 4, 5 or 8"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.d[0] = std::nan(""); }).find("no lens"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.distortion_model = "magic"; }).find("distortion_model"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.roi = {600, 0, 10, 100}; }).find("leaves the picture"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.roi = {4'294'967'295U, 0, 10, 100}; }).find("leaves the picture"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.binning_x = 1000; }).find("no picture"), std::string::npos);
}

/// A raw message of a colour picture.
ImageMessage raw(const std::string& encoding, const cv::Mat& pixels, std::uint32_t padding) {
  ImageMessage image;
  image.encoding = encoding;
  image.width = static_cast<std::uint32_t>(pixels.cols);
  image.height = static_cast<std::uint32_t>(pixels.rows);
  const std::size_t row = static_cast<std::size_t>(pixels.cols) * pixels.elemSize();
  image.step = static_cast<std::uint32_t>(row) + padding;
  for (int y = 0; y < pixels.rows; ++y) {
    image.data.insert(image.data.end(), pixels.ptr(y), pixels.ptr(y) + row);
    image.data.insert(image.data.end(), padding, 77);
  }
  return image;
}

TEST(EncodedPicture, EveryEncodingGivesTheSameColours) {
  // Blue to red, smooth, so that 4:2:2 loses next to nothing.
  cv::Mat bgr(24, 32, CV_8UC3);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 32; ++x) {
      bgr.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(200 - 4 * x), static_cast<std::uint8_t>(60 + 3 * y),
                                 static_cast<std::uint8_t>(40 + 4 * x)};
    }
  }
  cv::Mat rgb, rgba, bgra, grey, grey_bgr;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  cv::cvtColor(bgr, rgba, cv::COLOR_BGR2RGBA);
  cv::cvtColor(bgr, bgra, cv::COLOR_BGR2BGRA);
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey, grey_bgr, cv::COLOR_GRAY2BGR);
  const auto decoded = [](const EncodedPicture& picture) { return decode(picture, "topic", {32, 24}); };
  const auto worst = [](const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); };
  for (const std::uint32_t padding : {0U, 5U}) {
    EXPECT_EQ(worst(decoded(raw("bgr8", bgr, padding)), bgr), 0);
    EXPECT_EQ(worst(decoded(raw("rgb8", rgb, padding)), bgr), 0);
    EXPECT_EQ(worst(decoded(raw("rgba8", rgba, padding)), bgr), 0);
    EXPECT_EQ(worst(decoded(raw("bgra8", bgra, padding)), bgr), 0);
    EXPECT_EQ(worst(decoded(raw("mono8", grey, padding)), grey_bgr), 0);
  }
  // BT.601, studio swing, as cameras give it; worked out here.
  cv::Mat uyvy(24, 32, CV_8UC2), yuyv(24, 32, CV_8UC2);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 32; x += 2) {
      double sum_u = 0, sum_v = 0;
      for (int i = 0; i < 2; ++i) {
        const cv::Vec3b& c = bgr.at<cv::Vec3b>(y, x + i);
        const double b = c[0], g = c[1], r = c[2];
        const auto luma = static_cast<std::uint8_t>(std::lround(16 + 0.257 * r + 0.504 * g + 0.098 * b));
        sum_u += 128 - 0.148 * r - 0.291 * g + 0.439 * b;
        sum_v += 128 + 0.439 * r - 0.368 * g - 0.071 * b;
        uyvy.at<cv::Vec2b>(y, x + i)[1] = luma;
        yuyv.at<cv::Vec2b>(y, x + i)[0] = luma;
      }
      const auto u = static_cast<std::uint8_t>(std::lround(sum_u / 2)),
                 v = static_cast<std::uint8_t>(std::lround(sum_v / 2));
      uyvy.at<cv::Vec2b>(y, x)[0] = u;
      uyvy.at<cv::Vec2b>(y, x + 1)[0] = v;
      yuyv.at<cv::Vec2b>(y, x)[1] = u;
      yuyv.at<cv::Vec2b>(y, x + 1)[1] = v;
    }
  }
  EXPECT_LE(worst(decoded(raw("yuv422", uyvy, 6)), bgr), 6);
  EXPECT_LE(worst(decoded(raw("yuv422_yuy2", yuyv, 0)), bgr), 6);

  for (const char* ending : {".png", ".jpg"}) {
    CompressedImageMessage compressed;
    cv::imencode(ending, bgr, compressed.data);
    EXPECT_LE(worst(decoded(compressed), bgr), ending == std::string(".png") ? 0 : 12);
  }
}

TEST(EncodedPicture, RefusesWhatIsCutOffOrOfAnotherSize) {
  const cv::Mat pixels(24, 32, CV_8UC3, cv::Scalar(1, 2, 3));
  const auto error = [&](const std::function<void(ImageMessage&)>& change) {
    ImageMessage image = raw("bgr8", pixels, 4);
    change(image);
    return error_of([&] { static_cast<void>(decode(image, "topic", {32, 24})); });
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_EQ(error([](auto& i) { i.data.resize(i.data.size() - 4); }), "");  // padding of the last row
  EXPECT_NE(error([](auto& i) { i.data.resize(i.data.size() - 5); }).find("cut off"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.data.clear(); }).find("cut off"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.step = 95; }).find("cut off"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.step = 4'294'967'295U; }).find("cut off"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.width = 31; }).find("expected 32x24"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.height = 4'294'967'295U; }).find("expected 32x24"), std::string::npos);
  EXPECT_NE(error([](auto& i) { i.encoding = "bayer_rggb8"; }).find("not known"), std::string::npos);
  ImageMessage odd = raw("yuv422", cv::Mat(2, 3, CV_8UC2, cv::Scalar(0, 0)), 0);
  EXPECT_NE(error_of([&] { static_cast<void>(decode(odd, "topic", {3, 2})); }).find("odd width"), std::string::npos);

  CompressedImageMessage compressed;
  EXPECT_NE(error_of([&] { static_cast<void>(decode(compressed, "topic", {32, 24})); }), "");
  cv::imencode(".jpg", pixels, compressed.data);
  compressed.data.resize(compressed.data.size() - 10);
  EXPECT_NE(error_of([&] {
              static_cast<void>(decode(compressed, "topic", {32, 24}));
            }).find("cut off"),
            std::string::npos);
}

}  // namespace
}  // namespace foreview
