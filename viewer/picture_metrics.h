#pragma once
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace foreview {

/// How much a picture differs from the true one. Both CV_8UC3 and of one size; `mask` CV_8U of that size, only pixels
/// with a value other than 0 count; empty: all. Values of 0..255 in each of the three channels.
struct PixelError {
  std::size_t pixels = 0;    ///< counted
  double mean_squared = 0;   ///< over pixels and channels
  double mean_absolute = 0;  ///< over pixels and channels
  [[nodiscard]] double rms() const;
  /// 10 log10(255^2 / mean_squared), at most kMaxPsnr; none where no pixel was counted.
  [[nodiscard]] std::optional<double> psnr() const;
};
inline constexpr double kMaxPsnr = 100;  ///< dB; stands for "equal" in means and in JSON, which has no infinity

[[nodiscard]] PixelError pixel_error(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& mask = {});

/// The same, but each pixel is compared with the most similar of the truth's pixels within `reach` pixels of its place:
/// right colours a little out of place cost nothing, colours that belong to something else cost in full. Of equally
/// similar ones any will do. What is counted is the square and absolute difference to that pixel.
[[nodiscard]] PixelError displaced_error(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& mask, int reach);

/// Structural similarity (Wang et al. 2004, constants 0.01 and 0.03 of 255): on grey (OpenCV's BGR2GRAY), statistics in
/// an 11x11 Gaussian window, sigma 1.5, the picture mirrored at its borders (without repeating the outermost pixel);
/// mean over all pixels, or with `mask` over those whose window lies in the mask as far as it lies in the picture; none
/// where there is no such pixel.
[[nodiscard]] std::optional<double> structural_similarity(const cv::Mat& picture, const cv::Mat& truth,
                                                          const cv::Mat& mask = {});

}  // namespace foreview
