#include "foreview/recordings/synthetic/sensor_noise.h"

#include <cmath>
#include <opencv2/core.hpp>

#include "foreview/recordings/synthetic/noise.h"

namespace foreview::synthetic {
namespace {

/// Mean 0, variance 1.
float normal(std::uint32_t bits) {
  const auto sum = static_cast<float>((bits & 255U) + ((bits >> 8) & 255U) + ((bits >> 16) & 255U) + (bits >> 24));
  // Four numbers 0..255: mean 510, variance 4 (256^2 - 1) / 12.
  return (sum - 510.0F) * (1.0F / 147.8F);
}

}  // namespace

void add_sensor_noise(cv::Mat& picture, double sigma, double common, std::uint32_t seed) {
  const auto shared = static_cast<float>(sigma * std::sqrt(common));
  const auto own = static_cast<float>(sigma * std::sqrt(1 - common));
  for (int y = 0; y < picture.rows; ++y) {
    std::uint32_t counter = mix_bits(seed * 0x9e3779b1U + static_cast<std::uint32_t>(y));
    for (int x = 0; x < picture.cols; ++x) {
      auto& pixel = picture.at<cv::Vec3b>(y, x);
      const float together = shared * normal(mix_bits(counter++ * 0x9e3779b1U));
      for (int c = 0; c < 3; ++c) {
        const float noisy = static_cast<float>(pixel[c]) + together + own * normal(mix_bits(counter++ * 0x9e3779b1U));
        pixel[c] = cv::saturate_cast<std::uint8_t>(noisy);
      }
    }
  }
}

}  // namespace foreview::synthetic
