#pragma once
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "support/temporary_directory.h"

namespace foreview::test {

/// A picture in which every pixel differs from its neighbours, so that nothing lost goes unseen.
inline cv::Mat patterned_picture(int width, int height, int seed) {
  cv::Mat picture(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto byte = [&](int a, int b, int c) { return static_cast<unsigned char>(a * x + b * y + c * seed); };
      picture.at<cv::Vec3b>(y, x) = {byte(7, 3, 11), byte(5, 13, 17), byte(2, 9, 29)};
    }
  }
  return picture;
}

inline std::string encoded(const cv::Mat& picture, const std::string& ending, const std::vector<int>& options = {}) {
  std::vector<unsigned char> bytes;
  cv::imencode(ending, picture, bytes, options);
  return {bytes.begin(), bytes.end()};
}

/// A small whole recording: three pictures of 16x12 at 0, 0.1 and 0.2 s, poses from 0 to 0.2 s. Tests overwrite what
/// they want damaged.
struct SampleRecording {
  static constexpr const char* kCameraYaml =
      "image_width: 16\nimage_height: 12\ncamera_name: eye\ncamera_matrix: [20, 0, 7.5, 0, 20, 5.5, 0, 0, 1]\n";
  static constexpr const char* kList = "0.0 rgb/a.png\n0.1 rgb/b.jpg\n0.2 rgb/c.png\n";
  static constexpr const char* kPoses =
      "0.0 0 0 0 0 0 0 1\n"
      "0.1 1 0 0 0 0 0 1\n"
      "0.2 1 2 0 0 0 0 1\n";

  SampleRecording() {
    directory.write("camera.yaml", kCameraYaml);
    directory.write("rgb.txt", kList);
    directory.write("groundtruth.txt", kPoses);
    directory.write("rgb/a.png", encoded(patterned_picture(16, 12, 1), ".png"));
    directory.write("rgb/b.jpg", encoded(patterned_picture(16, 12, 2), ".jpg"));
    directory.write("rgb/c.png", encoded(patterned_picture(16, 12, 3), ".png"));
  }
  [[nodiscard]] Recording open() const { return Recording::open(directory.path()); }
  /// The message with which opening fails, without the directory's own path; empty where it does not fail.
  [[nodiscard]] std::string error() const {
    try {
      static_cast<void>(open());
    } catch (const InputError& failure) {
      std::string message = failure.what();
      const std::string path = directory.path().string() + "/";
      for (std::size_t at = message.find(path); at != std::string::npos; at = message.find(path)) {
        message.erase(at, path.size());
      }
      return message;
    }
    return "";
  }

  TemporaryDirectory directory;
};

}  // namespace foreview::test
