#pragma once
#include <opencv2/core/mat.hpp>
#include <string>

namespace foreview::testing {

/// How far a picture may be from its golden one, per channel, in 1/255. Loosen only with a comment that says why.
struct GoldenThresholds {
  double maximum = 2;  ///< of any channel of any pixel
  double mean = 0.1;   ///< over all channels and pixels
};

/// Compares with tests/golden/NAME.png. On failure NAME-expected.png, NAME-actual.png and NAME-difference.png (8 times
/// enlarged differences) lie in the build directory's test-output/golden; tests/accept-golden shows and accepts them.
/// Reports through GoogleTest (EXPECT).
void expect_golden(const cv::Mat& actual_bgr, const std::string& name, const GoldenThresholds& thresholds = {});

}  // namespace foreview::testing
