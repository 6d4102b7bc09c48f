// Polygons that are too small to own the centre of a pixel must get a colour, too, and the right one.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <opencv2/imgproc.hpp>

#include "foreview/recordings/recording.h"
#include "gpu/batched_scene.h"

namespace foreview {
namespace {

struct Sample {
  bool observed = false;  ///< the texel at its middle; else it was filled, or the polygon was not seen
  double difference = 0;  ///< of the polygon's colour from the picture's, mean over the channels, 1/255
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

cv::Vec3d bilinear(const cv::Mat& picture, const glm::dvec2& pixel) {
  cv::Mat patch;
  cv::getRectSubPix(picture, {1, 1}, {static_cast<float>(pixel.x - 0.5), static_cast<float>(pixel.y - 0.5)}, patch);
  return cv::Vec3d(patch.at<cv::Vec3b>(0, 0));
}

/// What is shown of a polygon, its middle: the chart's texel there, or its mean colour if no picture has shown it.
cv::Vec3d shown_colour(const TextureStore& store, const TextureBytes& bytes, std::size_t polygon,
                       const glm::dvec3& middle) {
  const TextureStore::PolygonState& state = bytes.states[polygon];
  if (state.seen < 1) return cv::Vec3d(state.blue, state.green, state.red) * 255;
  const Chart& chart = store.layout().charts[polygon];
  const glm::dvec2 at = chart.texel_from_part(middle);
  cv::Mat bgr;
  cv::cvtColor(bytes.levels[0][chart.page](cv::Rect(static_cast<int>(at.x) - 1, static_cast<int>(at.y) - 1, 3, 3)), bgr,
               cv::COLOR_BGRA2BGR);
  return bilinear(bgr, at - glm::floor(at) + 1.0);
}

TEST_F(BatchedTest, PolygonsSmallerThanAPixelLookAsTheirNeighboursDo) {
  const std::filesystem::path directory = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen";
  if (!std::filesystem::exists(directory / "scene.ply")) GTEST_SKIP() << "no kitchen recording at " << directory;
  Recording recording = Recording::open(directory);
  const PolygonModel model = import_model(directory / "scene.ply", recording.import_options());
  charts_.texels_per_metre = 200;
  charts_.max_texels = 256;
  charts_.page_size = 4096;
  struct Figures {
    std::vector<double> small, neighbours;
  };
  Figures observed_ones, other_ones;
  std::size_t without_colour = 0;
  for (const std::size_t index : {50U, 100U, 150U, 200U, 250U, 300U, 350U, 400U, 450U, 500U, 550U}) {
    const std::optional<CameraFrame> picture = recording.read_frame(0, index, model);
    ASSERT_TRUE(picture.has_value());
    BatchedRig rig(model, charts_);
    rig.pipeline.extract(*picture);
    const TextureBytes bytes = rig.bytes();
    const cv::Mat seen = rig.pipeline.intermediate().undistorted;
    const cv::Mat surfaces = rig.pipeline.intermediate().surfaces;
    cv::Mat bgr;
    cv::cvtColor(seen, bgr, cv::COLOR_BGRA2BGR);
    const CameraModel camera = picture->camera.undistorted();
    const Pose camera_from_world = picture->state.world_from_camera.inverse();

    // Front faces whose middle is in the picture, and not hidden there.
    std::vector<std::optional<Sample>> samples(model.polygons().size());
    std::vector<bool> owns_pixel(model.polygons().size(), false);
    for (std::size_t i = 0; i < model.polygons().size(); ++i) {
      const Polygon& polygon = model.polygons()[i];
      if (polygon.is_backdrop) continue;
      const Pose camera_from_part = camera_from_world * picture->state.world_from_part[polygon.part];
      glm::dvec3 middle(0);
      std::vector<cv::Point2f> corners;
      bool in_front = true;
      for (std::size_t k = 0; k < polygon.corner_count; ++k) {
        middle += model.corner(i, k) / static_cast<double>(polygon.corner_count);
        const glm::dvec3 p = camera_from_part * model.corner(i, k);
        in_front = in_front && p.z > 0.1;
        if (!in_front) break;
        const glm::dvec2 pixel = camera.pixel_from_camera(p);
        corners.emplace_back(static_cast<float>(pixel.x), static_cast<float>(pixel.y));
      }
      const glm::dvec3 in_camera = camera_from_part * middle;
      if (!in_front || glm::dot(camera_from_part.rotate(polygon.normal), in_camera) >= 0) continue;
      const glm::dvec2 pixel = camera.pixel_from_camera(in_camera);
      if (pixel.x < 3 || pixel.y < 3 || pixel.x > camera.width - 3 || pixel.y > camera.height - 3) continue;
      const float w = surfaces.at<cv::Vec3f>(static_cast<int>(pixel.y), static_cast<int>(pixel.x))[0];
      if (std::abs(w * in_camera.z - 1) > 0.02) continue;
      const cv::Rect box = cv::boundingRect(corners) + cv::Size(1, 1);
      for (int y = box.y; y < box.y + box.height && !owns_pixel[i]; ++y) {
        for (int x = box.x; x < box.x + box.width; ++x) {
          const cv::Point2f centre(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
          owns_pixel[i] = owns_pixel[i] || cv::pointPolygonTest(corners, centre, false) >= 0;
        }
      }
      const cv::Vec3d difference = shown_colour(rig.store, bytes, i, middle) - bilinear(bgr, pixel);
      bool observed = false;
      if (bytes.states[i].seen == 1) {
        const Chart& chart = rig.store.layout().charts[i];
        const glm::ivec2 at(chart.texel_from_part(middle));
        observed = bytes.levels[0][chart.page].at<cv::Vec4b>(at.y, at.x)[3] == 255;
      }
      samples[i] = {observed, (std::abs(difference[0]) + std::abs(difference[1]) + std::abs(difference[2])) / 3};
    }
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (!samples[i] || owns_pixel[i]) continue;
      (samples[i]->observed ? observed_ones : other_ones).small.push_back(samples[i]->difference);
      without_colour += bytes.states[i].seen == 0 ? 1 : 0;
      for (const std::uint32_t other : model.neighbours_of(i)) {
        if (!samples[other] || !owns_pixel[other]) continue;
        (samples[other]->observed ? observed_ones : other_ones).neighbours.push_back(samples[other]->difference);
      }
    }
  }
  EXPECT_EQ(without_colour, 0U);
  const auto tell = [](const Figures& figures, const std::string& what) {
    std::cout << what << ": " << figures.small.size() << " polygons without a pixel differ by "
              << cv::mean(figures.small)[0] << " (median " << median(figures.small) << "), their larger neighbours ("
              << figures.neighbours.size() << ") by " << cv::mean(figures.neighbours)[0] << " (median "
              << median(figures.neighbours) << "), of 255\n";
  };
  tell(observed_ones, "observed");
  tell(other_ones, "filled or not seen");
  Figures all = observed_ones;
  all.small.insert(all.small.end(), other_ones.small.begin(), other_ones.small.end());
  all.neighbours.insert(all.neighbours.end(), other_ones.neighbours.begin(), other_ones.neighbours.end());
  tell(all, "all");
  ASSERT_GT(all.small.size(), 200U);
  ASSERT_GT(all.neighbours.size(), 200U);
  EXPECT_LE(cv::mean(all.small)[0], cv::mean(all.neighbours)[0]);
  EXPECT_LE(cv::mean(observed_ones.small)[0], 1.1 * cv::mean(observed_ones.neighbours)[0]);
}

}  // namespace
}  // namespace foreview
