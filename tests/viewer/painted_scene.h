#pragma once
#include <algorithm>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "foreview/gpu/texture_store.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/viewer/predicted_view.h"

namespace foreview::test {

/// Colour in 0..255, red green blue.
using Rgb = glm::dvec3;

/// A model whose charts are painted by the test instead of by extraction.
class PaintedScene {
 public:
  /// Faces stay as they are: nothing merged, no backdrop. The options must not group polygons: paint() fills blocks.
  PaintedScene(const RawMesh& mesh, const ChartOptions& options) {
    ImportOptions import;
    import.merge_coplanar = false;
    import.backdrop = false;
    model_ = build_polygon_model(mesh, import);
    store_ = std::make_unique<TextureStore>(model_, lay_out_charts(model_, options));
    view_ = std::make_unique<PredictedView>(*store_);
    const int size = layout().page_size;
    for (std::uint32_t i = 0; i < layout().pages; ++i) pages_.emplace_back(size, size, CV_8UC4, cv::Scalar::all(0));
    states_.assign(model_.polygons().size(), {0.5F, 0.5F, 0.5F, 0.0F});
  }

  /// Every texel of all pages that belongs to no painted chart yet.
  void paint_ground(const Rgb& colour) {
    for (cv::Mat& page : pages_) page.setTo(bgra(colour, true));
  }
  /// The whole block of a polygon's chart, by position in the part's frame, and its state as seen.
  void paint(std::size_t polygon, const std::function<Rgb(const glm::dvec3&)>& colour, bool observed = true) {
    const Chart& chart = layout().charts[polygon];
    for (int y = 0; y < chart.size.y; ++y) {
      for (int x = 0; x < chart.size.x; ++x) {
        const glm::dvec2 texel = glm::dvec2(chart.origin) + glm::dvec2(x + 0.5, y + 0.5);
        set_texel(chart, x, y, colour(chart.part_from_texel(texel)), observed);
      }
    }
    set_state(polygon, colour(model_.corner(polygon, 0)), 1);
  }
  void paint(std::size_t polygon, const Rgb& colour, bool observed = true) {
    paint(
        polygon, [&](const glm::dvec3&) { return colour; }, observed);
  }
  /// A texel, from the block's upper left.
  void set_texel(const Chart& chart, int x, int y, const Rgb& colour, bool observed) {
    pages_[chart.page].at<cv::Vec4b>(chart.origin.y + y, chart.origin.x + x) = bgra(colour, observed);
  }
  void set_state(std::size_t polygon, const Rgb& colour, float seen) {
    states_[polygon] = {static_cast<float>(colour.r / 255), static_cast<float>(colour.g / 255),
                        static_cast<float>(colour.b / 255), seen};
  }
  /// To the GPU, levels included.
  void upload() {
    store_->write_pages(pages_, states_);
    std::vector<std::uint32_t> all(model_.polygons().size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    store_->update_levels(all);
  }

  [[nodiscard]] const PolygonModel& model() const { return model_; }
  [[nodiscard]] const ChartLayout& layout() const { return store_->layout(); }
  [[nodiscard]] PredictedView& view() { return *view_; }
  /// All parts at identity.
  [[nodiscard]] PredictedState seen_from(const Pose& world_from_camera) const {
    return {{}, world_from_camera, std::vector<Pose>(model_.parts().size())};
  }

 private:
  static cv::Vec4b bgra(const Rgb& colour, bool observed) {
    const auto byte = [](double value) { return cv::saturate_cast<std::uint8_t>(value); };
    return {byte(colour.b), byte(colour.g), byte(colour.r), static_cast<std::uint8_t>(observed ? 255 : 0)};
  }

  PolygonModel model_;
  std::unique_ptr<TextureStore> store_;
  std::unique_ptr<PredictedView> view_;
  std::vector<cv::Mat> pages_;
  std::vector<TextureStore::PolygonState> states_;
};

/// A rectangle in the plane z = depth, facing -z (towards a camera at the origin that looks along z): x right, y down,
/// cut into columns x rows faces.
inline RawMesh facing_rectangle(double width, double height, double depth, int columns = 1, int rows = 1) {
  RawMesh mesh;
  for (int y = 0; y <= rows; ++y) {
    for (int x = 0; x <= columns; ++x) {
      mesh.vertices.emplace_back(width * (static_cast<double>(x) / columns - 0.5),
                                 height * (static_cast<double>(y) / rows - 0.5), depth);
    }
  }
  const auto index = [&](int x, int y) { return static_cast<std::uint32_t>(y * (columns + 1) + x); };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      // Seen from the camera (y down): upper left, lower left, lower right, upper right is counter-clockwise.
      mesh.faces.push_back({index(x, y), index(x, y + 1), index(x + 1, y + 1), index(x + 1, y)});
    }
  }
  return mesh;
}

inline CameraModel pinhole(int width, int height, double focal_length) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.focal_length = {focal_length, focal_length};
  camera.principal_point = {0.5 * width, 0.5 * height};
  return camera;
}

/// Of the channel that differs most.
inline double distance(const Rgb& a, const Rgb& b) {
  const Rgb d = glm::abs(a - b);
  return std::max({d.r, d.g, d.b});
}

inline Rgb pixel(const cv::Mat& picture, int x, int y) {
  const auto& bgr = picture.at<cv::Vec3b>(y, x);
  return {bgr[2], bgr[1], bgr[0]};
}

}  // namespace foreview::test
