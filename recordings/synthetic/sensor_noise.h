#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace foreview::synthetic {

/// Adds nearly Gaussian noise (sum of four uniform numbers, cut at 3.5 sigma), independent per pixel; `sigma` in
/// 1/255. Channels share `common` (0..1) of the variance, as after a colour filter array. Depends only on the
/// arguments.
void add_sensor_noise(cv::Mat& picture, double sigma, double common, std::uint32_t seed);

}  // namespace foreview::synthetic
