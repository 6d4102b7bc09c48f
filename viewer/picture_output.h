#pragma once
#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace foreview {

/// Writes a picture (CV_8UC3 BGR or CV_8UC1) as PNG, whole at any moment, making its directory where it is missing. The
/// same picture gives the same bytes. Throws InputError naming the file where the disk refuses.
void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace foreview
