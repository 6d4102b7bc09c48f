#include "foreview/viewer/picture_metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace foreview {
namespace {

struct Difference {
  unsigned squares = 0, absolutes = 0;  ///< sums over the channels
};

Difference difference(const cv::Vec3b& a, const cv::Vec3b& b) {
  Difference result;
  for (int c = 0; c < 3; ++c) {
    const auto d = static_cast<unsigned>(std::abs(a[c] - b[c]));
    result.absolutes += d;
    result.squares += d * d;
  }
  return result;
}

struct ErrorSum {
  std::size_t pixels = 0;
  std::uint64_t squares = 0, absolutes = 0;
  void add(const Difference& d) {
    ++pixels;
    squares += d.squares;
    absolutes += d.absolutes;
  }
  [[nodiscard]] PixelError error() const {
    PixelError result;
    result.pixels = pixels;
    if (pixels == 0) return result;
    const double values = 3.0 * static_cast<double>(pixels);
    result.mean_squared = static_cast<double>(squares) / values;
    result.mean_absolute = static_cast<double>(absolutes) / values;
    return result;
  }
};

constexpr int kWindow = 11;
constexpr double kSigma = 1.5;

void assert_comparable([[maybe_unused]] const cv::Mat& picture, [[maybe_unused]] const cv::Mat& truth,
                       [[maybe_unused]] const cv::Mat& mask) {
  assert(picture.type() == CV_8UC3 && truth.type() == CV_8UC3 && picture.size() == truth.size());
  assert(mask.empty() || (mask.type() == CV_8UC1 && mask.size() == picture.size()));
}

cv::Mat windowed(const cv::Mat& values) {
  cv::Mat result;
  cv::GaussianBlur(values, result, {kWindow, kWindow}, kSigma, kSigma, cv::BORDER_REFLECT_101);
  return result;
}

cv::Mat grey(const cv::Mat& picture) {
  cv::Mat bytes, result;
  cv::cvtColor(picture, bytes, cv::COLOR_BGR2GRAY);
  bytes.convertTo(result, CV_64F);
  return result;
}

}  // namespace

double PixelError::rms() const {
  return std::sqrt(mean_squared);
}

std::optional<double> PixelError::psnr() const {
  if (pixels == 0) return std::nullopt;
  if (mean_squared <= 0) return kMaxPsnr;
  return std::min(kMaxPsnr, 10 * std::log10(255.0 * 255.0 / mean_squared));
}

PixelError pixel_error(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& mask) {
  return displaced_error(picture, truth, mask, 0);
}

PixelError displaced_error(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& mask, int reach) {
  assert_comparable(picture, truth, mask);
  assert(reach >= 0);
  ErrorSum sum;
  for (int y = 0; y < picture.rows; ++y) {
    const auto* const shown = picture.ptr<cv::Vec3b>(y);
    const std::uint8_t* const counts = mask.empty() ? nullptr : mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < picture.cols; ++x) {
      if (counts != nullptr && counts[x] == 0) continue;
      Difference closest = difference(shown[x], truth.at<cv::Vec3b>(y, x));
      for (int v = std::max(0, y - reach); v <= std::min(truth.rows - 1, y + reach); ++v) {
        const auto* const row = truth.ptr<cv::Vec3b>(v);
        for (int u = std::max(0, x - reach); u <= std::min(truth.cols - 1, x + reach); ++u) {
          if ((u - x) * (u - x) + (v - y) * (v - y) > reach * reach) continue;
          const Difference d = difference(shown[x], row[u]);
          if (d.squares < closest.squares) closest = d;
        }
      }
      sum.add(closest);
    }
  }
  return sum.error();
}

std::optional<double> structural_similarity(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& mask) {
  assert_comparable(picture, truth, mask);
  if (picture.empty()) return std::nullopt;
  constexpr double c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255;
  const cv::Mat a = grey(picture), b = grey(truth);
  const cv::Mat mean_a = windowed(a), mean_b = windowed(b);
  const cv::Mat mean_aa = windowed(a.mul(a)), mean_bb = windowed(b.mul(b)), mean_ab = windowed(a.mul(b));
  cv::Mat counts;
  if (!mask.empty()) {
    const cv::Mat window = cv::Mat::ones(kWindow, kWindow, CV_8U);
    // OpenCV's default border for erosion never erodes from the picture's rim.
    cv::erode(mask, counts, window);
  }
  double sum = 0;
  std::size_t pixels = 0;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      if (!counts.empty() && counts.at<std::uint8_t>(y, x) == 0) continue;
      const double ma = mean_a.at<double>(y, x), mb = mean_b.at<double>(y, x);
      const double variance_a = mean_aa.at<double>(y, x) - ma * ma, variance_b = mean_bb.at<double>(y, x) - mb * mb;
      const double covariance = mean_ab.at<double>(y, x) - ma * mb;
      sum += (2 * ma * mb + c1) * (2 * covariance + c2) / ((ma * ma + mb * mb + c1) * (variance_a + variance_b + c2));
      ++pixels;
    }
  }
  if (pixels == 0) return std::nullopt;
  return sum / static_cast<double>(pixels);
}

}  // namespace foreview
