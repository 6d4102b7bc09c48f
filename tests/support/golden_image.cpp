#include "support/golden_image.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace foreview::testing {
namespace {

namespace fs = std::filesystem;

void leave_for_inspection(const cv::Mat& expected, const cv::Mat& actual, const std::string& name) {
  const fs::path directory = fs::path(FOREVIEW_TEST_OUTPUT_DIR) / "golden";
  fs::create_directories(directory);
  cv::imwrite((directory / (name + "-actual.png")).string(), actual);
  if (expected.empty()) return;
  cv::imwrite((directory / (name + "-expected.png")).string(), expected);
  if (expected.size() != actual.size() || expected.type() != actual.type()) return;
  cv::Mat difference;
  cv::absdiff(expected, actual, difference);
  cv::imwrite((directory / (name + "-difference.png")).string(), difference * 8);
}

}  // namespace

void expect_golden(const cv::Mat& actual, const std::string& name, const GoldenThresholds& thresholds) {
  const fs::path file = fs::path(FOREVIEW_TEST_DIR) / "golden" / (name + ".png");
  const cv::Mat expected = cv::imread(file.string(), cv::IMREAD_COLOR);
  if (expected.empty()) {
    leave_for_inspection(expected, actual, name);
    ADD_FAILURE() << "no golden image " << name << "; look at the actual one, then run tests/accept-golden";
    return;
  }
  if (expected.size() != actual.size() || expected.type() != actual.type()) {
    leave_for_inspection(expected, actual, name);
    ADD_FAILURE() << name << ": " << actual.cols << "x" << actual.rows << ", golden " << expected.cols << "x"
                  << expected.rows;
    return;
  }
  cv::Mat difference;
  cv::absdiff(expected, actual, difference);
  double maximum = 0;
  cv::minMaxLoc(difference.reshape(1), nullptr, &maximum);
  const double mean = cv::mean(difference.reshape(1))[0];
  if (maximum > thresholds.maximum || mean > thresholds.mean) {
    leave_for_inspection(expected, actual, name);
    ADD_FAILURE() << name << " differs from its golden image: maximum " << maximum << " (allowed " << thresholds.maximum
                  << "), mean " << mean << " (allowed " << thresholds.mean << "); see test-output/golden";
  }
}

}  // namespace foreview::testing
