// Spec 8: no seams between textured polygons, no stray colours in unseen areas.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "foreview/gpu/extraction.h"
#include "foreview/viewer/predicted_view.h"
#include "gpu/gl_test_fixture.h"

namespace foreview {
namespace {

constexpr double kSide = 2;  // metres
constexpr double kTexelsPerMetre = 500;
const cv::Vec3b kStray{0, 0, 255};  // the plane itself has no red above 100

/// The plane z = 0 around the origin, seen from z < 0, cut into cells. `uncut`: one polygon.
using Faces = std::vector<std::vector<glm::dvec3>>;

/// Corners of a grid of cells x cells quadrilaterals; inner ones moved by up to `jitter` of a cell.
std::vector<glm::dvec3> grid_corners(int cells, double jitter) {
  std::mt19937 random(4);
  const auto offset = [&] { return jitter * (static_cast<double>(random()) / 2147483648.0 - 1) * kSide / cells; };
  std::vector<glm::dvec3> corners;
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      const double dx = offset(), dy = offset();
      corners.emplace_back(kSide * column / cells - kSide / 2 + (column > 0 && column < cells ? dx : 0),
                           kSide * row / cells - kSide / 2 + (row > 0 && row < cells ? dy : 0), 0);
    }
  }
  return corners;
}

RawMesh squares(int cells) {
  RawMesh mesh;
  mesh.vertices = grid_corners(cells, 0);
  const auto n = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t row = 0; row + 1 < n; ++row) {
    for (std::uint32_t column = 0; column + 1 < n; ++column) {
      const std::uint32_t a = row * n + column;
      mesh.faces.push_back({a, a + n, a + n + 1, a + 1});
    }
  }
  mesh.face_part.assign(mesh.faces.size(), 0);
  return mesh;
}

RawMesh irregular_triangles(int cells) {
  RawMesh mesh;
  mesh.vertices = grid_corners(cells, 0.3);
  const auto n = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t row = 0; row + 1 < n; ++row) {
    for (std::uint32_t column = 0; column + 1 < n; ++column) {
      const std::uint32_t a = row * n + column, b = a + n, c = b + 1, d = a + 1;
      if ((row * 7 + column * 5) % 3 == 0) {
        mesh.faces.push_back({a, b, c});
        mesh.faces.push_back({a, c, d});
      } else {
        mesh.faces.push_back({a, b, d});
        mesh.faces.push_back({b, c, d});
      }
    }
  }
  mesh.face_part.assign(mesh.faces.size(), 0);
  return mesh;
}

/// A plate that hides part of the plane from the camera, as a part of its own.
void add_occluder(RawMesh& mesh) {
  mesh.part_names = {"plane", "occluder"};
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const glm::dvec2 corner :
       {glm::dvec2(-0.21, -0.17), glm::dvec2(-0.21, 0.14), glm::dvec2(0.17, 0.14), glm::dvec2(0.17, -0.17)}) {
    mesh.vertices.emplace_back(corner, -0.6);
  }
  mesh.faces.push_back({first, first + 1, first + 2, first + 3});
  mesh.face_part.push_back(1);
}

glm::dvec3 gradient(const glm::dvec3& p) {
  const double s = p.x / kSide + 0.5, t = p.y / kSide + 0.5;
  return {255 * s, 255 * t, 50 * (s + 1 - t)};
}

CameraModel camera_of(int width, int height, double focal_length) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.focal_length = {focal_length, focal_length};
  camera.principal_point = {width / 2.0, height / 2.0};
  return camera;
}

/// What a camera sees of the plane, everything else in the stray colour.
CameraFrame picture_of_plane(const PolygonModel& model, const CameraModel& camera, const Pose& world_from_camera) {
  CameraFrame frame;
  frame.camera = camera;
  frame.state.world_from_camera = world_from_camera;
  frame.state.world_from_part.assign(model.parts().size(), Pose());
  frame.picture = cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar(kStray));
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const glm::dvec3 ray = world_from_camera.rotate(camera.ray_from_pixel({x + 0.5, y + 0.5}));
      const glm::dvec3& eye = world_from_camera.translation;
      const auto hit_at = [&](double z) { return eye + ray * ((z - eye.z) / ray.z); };
      if (model.parts().size() > 1) {
        const glm::dvec3 p = hit_at(-0.6);
        if (p.x > -0.21 && p.x < 0.17 && p.y > -0.17 && p.y < 0.14) continue;
      }
      const glm::dvec3 p = hit_at(0);
      if (std::abs(p.x) > kSide / 2 || std::abs(p.y) > kSide / 2) continue;
      const glm::dvec3 c = gradient(p);
      for (int i = 0; i < 3; ++i) {
        frame.picture.at<cv::Vec3b>(y, x)[i] = cv::saturate_cast<unsigned char>(c[i]);
      }
    }
  }
  return frame;
}

/// How a plane is textured.
struct Texturing {
  PipelineKind pipeline = PipelineKind::per_polygon;
  HoleFilling fill = HoleFilling::pyramid;
  bool group_polygons = false;
  int max_texels = 256;  ///< of the cut plane
};

/// A textured plane, ready to be looked at.
struct TexturedPlane {
  PolygonModel model;
  TextureStore store;
  std::unique_ptr<ExtractionPipeline> extraction;
  PredictedView view;

  static ChartOptions charts(const Texturing& how, int max_texels) {
    ChartOptions options;
    options.texels_per_metre = kTexelsPerMetre;
    options.max_texels = max_texels;
    options.page_size = 2048;
    options.group_polygons = how.group_polygons;
    return options;
  }
  static PolygonModel import(const RawMesh& mesh) {
    ImportOptions options;
    options.merge_coplanar = false;
    options.backdrop = false;
    return build_polygon_model(mesh, options);
  }
  TexturedPlane(const RawMesh& mesh, const Texturing& how, int max_texels)
      : model(import(mesh)),
        store(model, lay_out_charts(model, charts(how, max_texels))),
        extraction(make_extraction_pipeline(how.pipeline, store, charts(how, max_texels), with(how.fill))),
        view(store) {}
  static ExtractionOptions with(HoleFilling fill) {
    ExtractionOptions options;
    options.fill = fill;
    return options;
  }
  [[nodiscard]] PredictedState state(const Pose& world_from_camera) const {
    PredictedState result;
    result.world_from_camera = world_from_camera;
    result.world_from_part.assign(model.parts().size(), Pose());
    // The occluder leaves.
    if (result.world_from_part.size() > 1) result.world_from_part[1].translation = {0, 0, -100};
    return result;
  }
};

struct Difference {
  double largest = 0;
  int x = 0, y = 0;
  std::size_t pixels = 0;  ///< compared
};

/// Largest difference of any channel over the pixels that lie on the plane with `rim` pixels around them.
Difference difference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& polygon, int rim) {
  Difference result;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      bool inside = true;
      for (int dy = -rim; dy <= rim; ++dy) {
        for (int dx = -rim; dx <= rim; ++dx) {
          const int u = x + dx, v = y + dy;
          inside = inside && u >= 0 && v >= 0 && u < a.cols && v < a.rows && polygon.at<int>(v, u) >= 0;
        }
      }
      if (!inside) continue;
      ++result.pixels;
      for (int c = 0; c < 3; ++c) {
        const double d = std::abs(static_cast<double>(a.at<cv::Vec3b>(y, x)[c]) - b.at<cv::Vec3b>(y, x)[c]);
        if (d > result.largest) {
          result.largest = d;
          result.x = x;
          result.y = y;
        }
      }
    }
  }
  return result;
}

void keep(const cv::Mat& picture, const std::string& name) {
  const std::string directory = std::string(FOREVIEW_TEST_OUTPUT_DIR) + "/borders";
  std::filesystem::create_directories(directory);
  cv::imwrite(directory + "/" + name + ".png", picture);
}

const CameraModel kCapture = camera_of(760, 570, 620);
const CameraModel kViewer = camera_of(320, 240, 500);

Pose from(const glm::dvec3& eye, const glm::dvec3& target) {
  return looking_at(eye, target, {0, -1, 0});
}

/// Distance from which a mip level is read: one pixel of the viewer's camera covers 2^level texels, and half a level
/// more, because the view reads half a level finer than that.
double distance_of_level(double level) {
  return kViewer.focal_length.x / kTexelsPerMetre * std::exp2(level + 0.5);
}

class Borders : public GlTest {
 protected:
  /// The cut plane against the uncut one: near, at each mip level, straight and slanted.
  /// `coarse_tolerance`: at mip levels 3 and 4.
  static void compare(const RawMesh& cut_mesh, const Texturing& how, const Pose& capture, const std::string& name,
                      double coarse_tolerance = 2) {
    TexturedPlane uncut(squares(1), how, 1024), cut(cut_mesh, how, how.max_texels);
    (void)uncut.extraction->extract(picture_of_plane(uncut.model, kCapture, capture));
    (void)cut.extraction->extract(picture_of_plane(cut.model, kCapture, capture));
    struct View {
      std::string name;
      Pose pose;
    };
    std::vector<View> views{{"near", from({0.03, -0.02, -0.15}, {0.01, 0.02, 0})},
                            {"slanted", from({0.9, 0.4, -0.8}, {0, 0, 0})}};
    for (int level = 0; level < kChartLevels; ++level) {
      const double d = distance_of_level(level);
      views.push_back({"level" + std::to_string(level), from({0.01 * d, 0.02 * d, -d}, {0.004, -0.003, 0})});
      views.push_back({"between" + std::to_string(level),
                       from({0.014 * d, 0, -distance_of_level(level - 0.4)}, {0.004, -0.003, 0})});
    }
    for (const View& v : views) {
      const cv::Mat expected = uncut.view.render(kViewer, uncut.state(v.pose));
      const cv::Mat actual = cut.view.render(kViewer, cut.state(v.pose));
      // Beyond the plane lies nothing, so the pixels along its outer edges are not safely its own and give no texels.
      // Where holes stay open these are grey, in whole texels of each mip level, which lie differently in the two.
      const int rim = how.fill == HoleFilling::none ? 4 : 1;
      const cv::Mat polygon = cut.view.render_surface(kViewer, cut.state(v.pose)).polygon;
      const Difference d = difference(expected, actual, polygon, rim);
      std::cout << name << ", " << v.name << ": " << d.largest << "/255 over " << d.pixels << " pixels\n";
      EXPECT_GE(d.pixels, 1000u);
      const bool is_coarse = v.name.ends_with('3') || v.name.ends_with('4');
      const double tolerance = is_coarse ? coarse_tolerance : 2;
      EXPECT_LE(d.largest, tolerance) << name << ", " << v.name << " at (" << d.x << ", " << d.y
                                      << "): " << actual.at<cv::Vec3b>(d.y, d.x) << " instead of "
                                      << expected.at<cv::Vec3b>(d.y, d.x);
      if (d.largest > tolerance) {
        keep(expected, name + "-" + v.name + "-uncut");
        keep(actual, name + "-" + v.name + "-cut");
      }
    }
  }
};

const Pose kStraight = from({0, 0, -2.4}, {0, 0, 0});
const Pose kSlanted = from({1.5, -0.9, -2.6}, {0.05, 0, 0});

TEST_F(Borders, SquaresRenderLikeTheUncutPlane) {
  compare(squares(4), {.fill = HoleFilling::pyramid}, kStraight, "squares, pyramid, straight");
  compare(squares(4), {.fill = HoleFilling::pyramid}, kSlanted, "squares, pyramid, slanted");
}

TEST_F(Borders, SquaresRenderLikeTheUncutPlaneWithoutHoleFilling) {
  compare(squares(4), {.fill = HoleFilling::none}, kSlanted, "squares, no filling, slanted");
}

TEST_F(Borders, IrregularTrianglesRenderLikeTheUncutPlane) {
  compare(irregular_triangles(5), {.fill = HoleFilling::pyramid}, kStraight, "triangles, pyramid, straight");
  compare(irregular_triangles(5), {.fill = HoleFilling::pyramid}, kSlanted, "triangles, pyramid, slanted");
}

TEST_F(Borders, IrregularTrianglesRenderLikeTheUncutPlaneWithoutHoleFilling) {
  compare(irregular_triangles(5), {.fill = HoleFilling::none}, kStraight, "triangles, no filling, straight");
}

const Texturing kBatched{.pipeline = PipelineKind::batched};
/// Several polygons in a chart, but not all: there are borders of both kinds.
const Texturing kBatchedGrouped{.pipeline = PipelineKind::batched, .group_polygons = true, .max_texels = 600};

/// Levels hold the mean of what was observed under a texel, however little (rule 7 of BatchedExtraction). Along a
/// slanted border that is up to a half of the texel, whose mean lies up to a quarter of a texel beside its centre:
/// 1/255 at level 4 of this gradient, to either side of the border; and less is observed yet where two borders meet.
constexpr double kSlantedBorders = 4;

TEST_F(Borders, BatchedSquaresRenderLikeTheUncutPlane) {
  compare(squares(4), kBatched, kStraight, "batched squares, straight");
  compare(squares(4), kBatched, kSlanted, "batched squares, slanted");
}

TEST_F(Borders, BatchedTrianglesRenderLikeTheUncutPlane) {
  compare(irregular_triangles(5), kBatched, kStraight, "batched triangles, straight", kSlantedBorders);
  compare(irregular_triangles(5), kBatched, kSlanted, "batched triangles, slanted", kSlantedBorders);
}

TEST_F(Borders, BatchedGroupsRenderLikeTheUncutPlane) {
  {
    const TexturedPlane plane(irregular_triangles(5), kBatchedGrouped, kBatchedGrouped.max_texels);
    const ChartLayout& layout = plane.store.layout();
    EXPECT_GT(layout.groups.size(), 1U);
    EXPECT_LT(layout.groups.size(), layout.charts.size());
  }
  compare(squares(4), kBatchedGrouped, kStraight, "batched grouped squares, straight");
  compare(squares(4), kBatchedGrouped, kSlanted, "batched grouped squares, slanted");
  compare(irregular_triangles(5), kBatchedGrouped, kStraight, "batched grouped triangles, straight", kSlantedBorders);
  compare(irregular_triangles(5), kBatchedGrouped, kSlanted, "batched grouped triangles, slanted", kSlantedBorders);
}

/// The comparison above is worth something only if its views really read each mip level.
TEST_F(Borders, EachLevelIsReallyUsed) {
  TexturedPlane cut(squares(4), {}, 256);
  (void)cut.extraction->extract(picture_of_plane(cut.model, kCapture, kStraight));
  std::vector<std::uint32_t> all(cut.model.polygons().size());
  std::iota(all.begin(), all.end(), 0U);
  for (int level = kChartLevels - 1; level >= 0; --level) {
    const double d = distance_of_level(level);
    EXPECT_NEAR(std::log2(kTexelsPerMetre * d / kViewer.focal_length.x), level + 0.5, 1e-9);
    const PredictedState state = cut.state(from({0, 0, -d}, {0, 0, 0}));
    EXPECT_NE(cut.view.render(kViewer, state).at<cv::Vec3b>(118, 158)[2], 255);
    const std::array<unsigned char, 4> red{255, 0, 0, 255};
    glClearTexImage(cut.store.pages(), level, GL_RGBA, GL_UNSIGNED_BYTE, red.data());
    EXPECT_GT(cut.view.render(kViewer, state).at<cv::Vec3b>(118, 158)[2], 200) << "level " << level;
    if (level > 0) cut.store.update_levels(all);
  }
}

/// A plate hides the plane's middle in the only picture. Once it has gone, nothing of its colour may show, neither in
/// the hole, however it is filled, nor across the borders around it; and what was seen must be right.
void expect_no_stray_colour(const RawMesh& plane, const Texturing& how, const std::string& name) {
  const HoleFilling fill = how.fill;
  RawMesh mesh = plane;
  add_occluder(mesh);
  TexturedPlane cut(mesh, how, how.max_texels);
  (void)cut.extraction->extract(picture_of_plane(cut.model, kCapture, kSlanted));
  for (const double distance : {0.4, 1.0, 2.0, 4.0, 8.0}) {
    const PredictedState state = cut.state(from({-0.1 * distance, 0.05, -distance}, {-0.2, 0.1, 0}));
    const cv::Mat picture = cut.view.render(kViewer, state);
    const PredictedView::Surface surface = cut.view.render_surface(kViewer, state);
    // Magnified, a hole's colour reaches one texel into what was observed.
    const int reach = 2 + static_cast<int>(std::ceil(1.5 * kViewer.focal_length.x / (kTexelsPerMetre * distance)));
    int strays = 0, wrong = 0, coloured = 0, filled = 0, observed = 0;
    double worst = 0;
    for (int y = 0; y < kViewer.height; ++y) {
      for (int x = 0; x < kViewer.width; ++x) {
        if (surface.polygon.at<int>(y, x) < 0) continue;
        const auto& bgr = picture.at<cv::Vec3b>(y, x);
        if (bgr[2] > (fill == HoleFilling::none ? 128 : 102)) ++strays;
        if (surface.provenance.at<unsigned char>(y, x) == 1) ++filled;
        bool all_observed = true, none_observed = true;
        for (int dy = -reach; dy <= reach; ++dy) {
          for (int dx = -reach; dx <= reach; ++dx) {
            const int u = std::clamp(x + dx, 0, kViewer.width - 1), v = std::clamp(y + dy, 0, kViewer.height - 1);
            all_observed = all_observed && surface.provenance.at<unsigned char>(v, u) == 2;
            none_observed = none_observed && surface.provenance.at<unsigned char>(v, u) != 2;
          }
        }
        // An open hole is grey throughout, also where borders cross it. Seen slanted, a share of level 1 is mixed in,
        // whose texels along a border have a little of the colours that lie more than two texels beyond it.
        if (none_observed && fill == HoleFilling::none && distance <= 1.0) {
          for (int c = 0; c < 3; ++c) coloured += std::abs(bgr[c] - 128) > 8 ? 1 : 0;
        }
        if (!all_observed) continue;
        ++observed;
        const glm::dvec3 ray = state.world_from_camera.rotate(kViewer.ray_from_pixel({x + 0.5, y + 0.5}));
        const glm::dvec3 eye = state.world_from_camera.translation;
        const glm::dvec3 expected = gradient(eye + ray * (-eye.z / ray.z));
        for (int c = 0; c < 3; ++c) {
          const double d = std::abs(bgr[c] - expected[c]);
          worst = std::max(worst, d);
          if (d > 3) ++wrong;
        }
      }
    }
    std::cout << name << " from " << distance << " m: " << observed << " pixels observed, " << filled
              << " filled; worst observed " << worst << "/255\n";
    EXPECT_GT(filled, 30) << name << ", " << distance;
    EXPECT_GT(observed, 30) << name << ", " << distance;
    EXPECT_EQ(strays, 0) << name << ", " << distance;
    EXPECT_EQ(coloured, 0) << name << ", " << distance;
    EXPECT_EQ(wrong, 0) << name << ", " << distance;
    if (strays + wrong + coloured > 0) keep(picture, name + "-" + std::to_string(distance));
  }
}

TEST_F(Borders, NoStrayColoursAroundAFilledHole) {
  expect_no_stray_colour(squares(4), {.fill = HoleFilling::pyramid}, "squares, pyramid");
  expect_no_stray_colour(squares(4), {.fill = HoleFilling::iterative}, "squares, iterative");
  expect_no_stray_colour(irregular_triangles(5), {.fill = HoleFilling::pyramid}, "triangles, pyramid");
}

TEST_F(Borders, BatchedLeavesNoStrayColoursAroundAFilledHole) {
  expect_no_stray_colour(squares(4), kBatched, "batched squares");
  expect_no_stray_colour(irregular_triangles(5), kBatched, "batched triangles");
  expect_no_stray_colour(irregular_triangles(5), kBatchedGrouped, "batched grouped triangles");
}

TEST_F(Borders, NoStrayColoursAroundAHoleThatStaysOpen) {
  expect_no_stray_colour(squares(4), {.fill = HoleFilling::none}, "squares, no filling");
  expect_no_stray_colour(irregular_triangles(5), {.fill = HoleFilling::none}, "triangles, no filling");
}

}  // namespace
}  // namespace foreview
