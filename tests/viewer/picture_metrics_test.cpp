#include "foreview/viewer/picture_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <random>

namespace foreview {
namespace {

cv::Mat noise(int width, int height, unsigned seed) {
  cv::Mat picture(height, width, CV_8UC3);
  std::mt19937 random(seed);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) picture.at<cv::Vec3b>(y, x)[c] = static_cast<std::uint8_t>(random() % 256);
    }
  }
  return picture;
}

/// Noise that follows `picture`, so that SSIM is neither 0 nor 1.
cv::Mat disturbed(const cv::Mat& picture, unsigned seed) {
  cv::Mat result = picture.clone();
  std::mt19937 random(seed);
  for (int y = 0; y < result.rows; ++y) {
    for (int x = 0; x < result.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& value = result.at<cv::Vec3b>(y, x)[c];
        value = cv::saturate_cast<std::uint8_t>(0.7 * value + static_cast<double>(random() % 100));
      }
    }
  }
  return result;
}

int mirrored(int i, int size) {
  if (i < 0) return -i;
  return i >= size ? 2 * size - 2 - i : i;
}

/// SSIM of Wang et al. as it stands in the paper, one window after the other.
double plain_ssim(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = {}) {
  const auto grey = [](const cv::Vec3b& v) {  // OpenCV's fixed-point BGR2GRAY
    return static_cast<double>((v[0] * 3735 + v[1] * 19235 + v[2] * 9798 + 16384) >> 15);
  };
  double kernel[11][11], whole = 0;
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 11; ++i) {
      kernel[j][i] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
      whole += kernel[j][i];
    }
  }
  double sum = 0;
  int counted = 0;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
      bool counts = true;
      for (int j = 0; j < 11; ++j) {
        for (int i = 0; i < 11; ++i) {
          const int u = x + i - 5, v = y + j - 5;
          const bool inside = u >= 0 && v >= 0 && u < a.cols && v < a.rows;
          if (inside && !mask.empty() && mask.at<std::uint8_t>(v, u) == 0) counts = false;
          const double w = kernel[j][i] / whole;
          const double pa = grey(a.at<cv::Vec3b>(mirrored(v, a.rows), mirrored(u, a.cols)));
          const double pb = grey(b.at<cv::Vec3b>(mirrored(v, a.rows), mirrored(u, a.cols)));
          ma += w * pa;
          mb += w * pb;
          aa += w * pa * pa;
          bb += w * pb * pb;
          ab += w * pa * pb;
        }
      }
      if (!counts) continue;
      const double c1 = 6.5025, c2 = 58.5225;
      sum += (2 * ma * mb + c1) * (2 * (ab - ma * mb) + c2) /
             ((ma * ma + mb * mb + c1) * (aa - ma * ma + bb - mb * mb + c2));
      ++counted;
    }
  }
  return sum / counted;
}

TEST(PictureMetrics, KnownErrors) {
  const cv::Mat black(7, 9, CV_8UC3, cv::Scalar::all(0)), dark(7, 9, CV_8UC3, cv::Scalar::all(10));
  EXPECT_NEAR(*pixel_error(dark, black).psnr(), 20 * std::log10(25.5), 1e-12);
  EXPECT_DOUBLE_EQ(pixel_error(dark, black).rms(), 10);
  EXPECT_EQ(pixel_error(dark, black).pixels, 63U);
  // All three channels count: one of them off by 30 is a mean square of 300.
  const cv::Mat blue(7, 9, CV_8UC3, cv::Scalar(30, 0, 0));
  EXPECT_DOUBLE_EQ(pixel_error(blue, black).mean_squared, 300);
  EXPECT_DOUBLE_EQ(pixel_error(black, blue).mean_absolute, 10);
  EXPECT_EQ(*pixel_error(black, black).psnr(), kMaxPsnr);
  const cv::Mat white(7, 9, CV_8UC3, cv::Scalar::all(255));
  EXPECT_EQ(*pixel_error(black, white).psnr(), 0);
}

TEST(PictureMetrics, MaskedErrorIsThatOfThePlainLoop) {
  const cv::Mat a = noise(31, 23, 1), b = disturbed(a, 2);
  cv::Mat mask(23, 31, CV_8U, cv::Scalar::all(0));
  double squares = 0;
  int pixels = 0;
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 31; ++x) {
      if ((x * 7 + y * 3) % 5 >= 2) continue;
      mask.at<std::uint8_t>(y, x) = 1;
      ++pixels;
      for (int c = 0; c < 3; ++c) squares += std::pow(a.at<cv::Vec3b>(y, x)[c] - b.at<cv::Vec3b>(y, x)[c], 2.0);
    }
  }
  const PixelError error = pixel_error(a, b, mask);
  EXPECT_EQ(error.pixels, static_cast<std::size_t>(pixels));
  EXPECT_NEAR(error.mean_squared, squares / (3 * pixels), 1e-9);
  EXPECT_NE(error.mean_squared, pixel_error(a, b).mean_squared);
  mask = 0;
  EXPECT_FALSE(pixel_error(a, b, mask).psnr().has_value());
  EXPECT_FALSE(structural_similarity(a, b, mask).has_value());
}

TEST(PictureMetrics, SsimOfConstantPictures) {
  const cv::Mat a(20, 20, CV_8UC3, cv::Scalar::all(100)), b(20, 20, CV_8UC3, cv::Scalar::all(150));
  EXPECT_NEAR(*structural_similarity(a, b), (2 * 100 * 150 + 6.5025) / (100 * 100 + 150 * 150 + 6.5025), 1e-9);
  EXPECT_NEAR(*structural_similarity(a, a), 1, 1e-12);
}

TEST(PictureMetrics, SsimIsThatOfThePlainLoop) {
  const cv::Mat a = noise(29, 21, 3), b = disturbed(a, 4);
  const double expected = plain_ssim(a, b);
  EXPECT_GT(expected, 0.2);
  EXPECT_LT(expected, 0.95);
  EXPECT_NEAR(*structural_similarity(a, b), expected, 1e-9);
  EXPECT_NEAR(*structural_similarity(a, a), 1, 1e-12);
}

TEST(PictureMetrics, MaskedSsimCountsOnlyWindowsWithinTheMask) {
  const cv::Mat a = noise(40, 30, 5);
  cv::Mat b = disturbed(a, 6);
  cv::Mat mask(30, 40, CV_8U, cv::Scalar::all(255));
  mask(cv::Rect(0, 0, 12, 30)) = 0;
  const double expected = plain_ssim(a, b, mask);
  EXPECT_NEAR(*structural_similarity(a, b, mask), expected, 1e-9);
  // What lies outside the mask has no influence at all.
  b(cv::Rect(0, 0, 12, 30)) = cv::Scalar(255, 0, 255);
  EXPECT_NEAR(*structural_similarity(a, b, mask), expected, 1e-9);
}

TEST(PictureMetrics, OnePixelPictures) {
  const cv::Mat a(1, 1, CV_8UC3, cv::Scalar::all(100)), b(1, 1, CV_8UC3, cv::Scalar::all(150));
  EXPECT_NEAR(*structural_similarity(a, b), (2 * 100 * 150 + 6.5025) / (100 * 100 + 150 * 150 + 6.5025), 1e-9);
}

TEST(DisplacedError, ForgivesDisplacementButNotForeignColours) {
  cv::Mat truth(40, 60, CV_8UC3);
  cv::RNG random(7);
  random.fill(truth, cv::RNG::UNIFORM, 0, 128);  // dark, so that white is foreign
  cv::Mat shown;
  cv::copyMakeBorder(truth(cv::Rect(3, 0, 57, 40)), shown, 0, 0, 0, 3, cv::BORDER_REPLICATE);  // 3 pixels to the left
  const cv::Rect inside(6, 6, 40, 28);
  cv::Mat mask(truth.size(), CV_8U, cv::Scalar::all(0));
  mask(inside) = 255;
  EXPECT_GT(pixel_error(shown, truth, mask).rms(), 30);
  EXPECT_GT(displaced_error(shown, truth, mask, 2).rms(), 5);
  EXPECT_EQ(displaced_error(shown, truth, mask, 3).mean_squared, 0);
  EXPECT_EQ(displaced_error(shown, truth, mask, 3).pixels, static_cast<std::size_t>(inside.area()));

  shown(cv::Rect(10, 10, 4, 7)) = cv::Scalar::all(255);
  const PixelError ghost = displaced_error(shown, truth, mask, 6);
  EXPECT_GT(ghost.mean_squared * inside.area(), 28 * 127.0 * 127.0);
  EXPECT_LT(ghost.mean_squared * inside.area(), 28 * 255.0 * 255.0);
}

TEST(DisplacedError, StaysInsideThePicture) {
  cv::Mat truth(3, 3, CV_8UC3, cv::Scalar::all(10)), shown(3, 3, CV_8UC3, cv::Scalar::all(17));
  EXPECT_DOUBLE_EQ(displaced_error(shown, truth, {}, 50).rms(), 7);
  EXPECT_EQ(displaced_error(shown, truth, {}, 50).pixels, 9U);
}

}  // namespace
}  // namespace foreview
