#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/per_polygon/per_polygon_extraction.h"
#include "gpu/gl_test_fixture.h"

namespace foreview {

/// Colour at a position in the picture, BGR: rises linearly, so that interpolating it changes nothing.
inline cv::Vec3d gradient(double u, double v) {
  return {20 + u, 30 + v, 200 - 0.5 * u - 0.5 * v};
}

/// A quad in the plane z = `depth` of the camera's frame, from (x0, y0) to (x1, y1) metres, front towards the camera.
inline void add_quad(RawMesh& mesh, double x0, double y0, double x1, double y1, double depth) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{x0, y0, depth}, {x0, y1, depth}, {x1, y1, depth}, {x1, y0, depth}});
  mesh.faces.push_back({first, first + 1, first + 2, first + 3});
}

/// A model of a few quads before a camera of 160 x 120 pixels and f = 100: 100 texels per metre are 1 texel per pixel
/// at a distance of 1 m. The principal point is off the pixel grid, so that no sample lies on a pixel's edge.
class ExtractionTest : public GlTest {
 protected:
  ExtractionTest() {
    camera_.width = 160;
    camera_.height = 120;
    camera_.focal_length = {100, 100};
    camera_.principal_point = {80.3, 60.2};
    charts_.texels_per_metre = 100;
    charts_.max_texels = 256;
    charts_.page_size = 1024;
    charts_.group_polygons = false;
    options_.small_texture = 0;
  }

  void build(const RawMesh& mesh) {
    pipeline_.reset();
    store_.reset();
    ImportOptions import;
    import.backdrop = false;
    import.merge_coplanar = false;
    model_ = std::make_unique<PolygonModel>(build_polygon_model(mesh, import));
    store_ = std::make_unique<TextureStore>(*model_, lay_out_charts(*model_, charts_));
    pipeline_ = std::make_unique<PerPolygonExtraction>(*store_, charts_, options_);
  }

  [[nodiscard]] CameraFrame frame(const std::function<cv::Vec3d(double, double)>& colour = gradient,
                                  double seconds = 1) const {
    CameraFrame result;
    result.camera = camera_;
    result.picture.create(camera_.height, camera_.width, CV_8UC3);
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        const cv::Vec3d c = colour(x + 0.5, y + 0.5);
        result.picture.at<cv::Vec3b>(y, x) =
            cv::Vec3b(cv::saturate_cast<uchar>(c[0]), cv::saturate_cast<uchar>(c[1]), cv::saturate_cast<uchar>(c[2]));
      }
    }
    result.state.stamp = Timestamp::from_seconds(seconds);
    result.state.world_from_part.resize(model_->parts().size());
    return result;
  }
  [[nodiscard]] static std::function<cv::Vec3d(double, double)> plain(double grey) {
    return [grey](double, double) { return cv::Vec3d(grey, grey, grey); };
  }

  /// The polygon whose corners' mean is nearest to `centre`: the importer need not keep the order of faces.
  [[nodiscard]] std::uint32_t polygon_at(const glm::dvec3& centre) const {
    std::uint32_t best = 0;
    double least = 1e30;
    for (std::uint32_t i = 0; i < model_->polygons().size(); ++i) {
      glm::dvec3 mean(0);
      const std::uint32_t count = model_->polygons()[i].corner_count;
      for (std::uint32_t k = 0; k < count; ++k) mean += model_->corner(i, k) / static_cast<double>(count);
      if (glm::length(mean - centre) < least) {
        least = glm::length(mean - centre);
        best = i;
      }
    }
    return best;
  }
  /// Pixel of the centre of a texel of a polygon's texture, the camera standing at the origin.
  [[nodiscard]] glm::dvec2 pixel_of_texel(std::uint32_t polygon, int x, int y, const cv::Mat& texture) const {
    const PolygonFrame plane = polygon_frame(*model_, polygon);
    const glm::dvec2 q = glm::dvec2(x + 0.5, y + 0.5) / glm::dvec2(texture.cols, texture.rows) * plane.extent;
    return camera_.undistorted().pixel_from_camera(plane.part_from_plane(q));
  }
  static void expect_colour(const cv::Vec4b& texel, const cv::Vec3d& expected, double tolerance,
                            const std::string& where) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(texel[c], expected[c], tolerance) << where << ", channel " << c;
  }
  [[nodiscard]] static int count_zeros(const cv::Mat& alpha) {
    return static_cast<int>(alpha.total()) - cv::countNonZero(alpha);
  }

  CameraModel camera_;
  ChartOptions charts_;
  ExtractionOptions options_;
  std::unique_ptr<PolygonModel> model_;
  std::unique_ptr<TextureStore> store_;
  std::unique_ptr<PerPolygonExtraction> pipeline_;
};

}  // namespace foreview
