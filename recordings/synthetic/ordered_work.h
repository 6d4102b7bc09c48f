#pragma once
#include <cstddef>
#include <functional>
#include <opencv2/core/mat.hpp>

namespace foreview::synthetic {

/// Makes `count` pictures on several threads and hands them over in order, in the calling thread; never more than a
/// few wait. An exception of either function ends the work and comes out of this call.
void make_in_order(std::size_t count, const std::function<cv::Mat(std::size_t)>& make,
                   const std::function<void(std::size_t, const cv::Mat&)>& take);

}  // namespace foreview::synthetic
