#pragma once
#include <memory>
#include <opencv2/core.hpp>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/batched/batched_extraction.h"
#include "gpu/extraction_scene.h"
#include "gpu/gl_test_fixture.h"

namespace foreview {

/// All bytes of a set of textures.
struct TextureBytes {
  std::vector<std::vector<cv::Mat>> levels;  ///< by level, then page; CV_8UC4 BGRA
  std::vector<TextureStore::PolygonState> states;
  std::vector<cv::Mat> capture_times;  ///< CV_32S

  static TextureBytes of(const TextureStore& store, GLuint pages, GLuint polygon_states, GLuint capture_times) {
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    TextureBytes bytes;
    const ChartLayout& layout = store.layout();
    for (int level = 0; level < kChartLevels; ++level) {
      const int size = layout.page_size >> level;
      std::vector<cv::Mat>& pictures = bytes.levels.emplace_back();
      for (std::uint32_t page = 0; page < layout.pages; ++page) {
        cv::Mat& picture = pictures.emplace_back(size, size, CV_8UC4);
        glGetTextureSubImage(pages, level, 0, 0, static_cast<GLint>(page), size, size, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                             size * size * 4, picture.data);
      }
    }
    bytes.states.resize(store.model().polygons().size());
    glGetNamedBufferSubData(polygon_states, 0,
                            static_cast<GLsizeiptr>(bytes.states.size() * sizeof(TextureStore::PolygonState)),
                            bytes.states.data());
    const int blocks = layout.page_size / kChartAlignment;
    for (std::uint32_t page = 0; page < layout.pages; ++page) {
      cv::Mat& times = bytes.capture_times.emplace_back(blocks, blocks, CV_32S);
      glGetTextureSubImage(capture_times, 0, 0, 0, static_cast<GLint>(page), blocks, blocks, 1, GL_RED_INTEGER, GL_INT,
                           blocks * blocks * 4, times.data);
    }
    return bytes;
  }
  static TextureBytes of(const TextureStore& store) {
    return of(store, store.pages(), store.polygon_states(), store.capture_times());
  }

  [[nodiscard]] int count_observed() const {
    int observed = 0;
    for (const cv::Mat& page : levels[0]) {
      std::vector<cv::Mat> channels;
      cv::split(page, channels);
      observed += cv::countNonZero(channels[3] == 255);
    }
    return observed;
  }
};

/// Where two sets of textures differ first, or nothing.
inline std::string difference(const TextureBytes& a, const TextureBytes& b) {
  for (std::size_t level = 0; level < a.levels.size(); ++level) {
    for (std::size_t page = 0; page < a.levels[level].size(); ++page) {
      const cv::Mat_<cv::Vec4b>&x = a.levels[level][page], &y = b.levels[level][page];
      for (int row = 0; row < x.rows; ++row) {
        for (int column = 0; column < x.cols; ++column) {
          if (x(row, column) == y(row, column)) continue;
          std::ostringstream text;
          text << "level " << level << ", page " << page << ", texel " << column << ", " << row << ": "
               << x(row, column) << " and " << y(row, column);
          return text.str();
        }
      }
    }
  }
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    if (a.states[i] != b.states[i]) return "state " + std::to_string(i);
  }
  for (std::size_t page = 0; page < a.capture_times.size(); ++page) {
    if (cv::norm(a.capture_times[page], b.capture_times[page], cv::NORM_INF) != 0) {
      return "capture times, page " + std::to_string(page);
    }
  }
  return {};
}

inline PolygonModel import_as_it_is(const RawMesh& mesh) {
  ImportOptions import;
  import.backdrop = false;
  import.merge_coplanar = false;
  return build_polygon_model(mesh, import);
}

/// A store and the batched pipeline that writes it.
struct BatchedRig {
  TextureStore store;
  BatchedExtraction pipeline;

  BatchedRig(const PolygonModel& model, const ChartOptions& charts, const ExtractionOptions& options = {},
             Publishing publishing = Publishing::direct)
      : store(model, lay_out_charts(model, charts), publishing), pipeline(store, options) {}
  [[nodiscard]] TextureBytes bytes() const { return TextureBytes::of(store); }
};

/// Camera as ExtractionTest's, and scenes for many pictures.
class BatchedTest : public GlTest {
 protected:
  BatchedTest() {
    camera_.width = 160;
    camera_.height = 120;
    camera_.focal_length = {100, 100};
    camera_.principal_point = {80.3, 60.2};
    charts_.texels_per_metre = 100;
    charts_.max_texels = 128;
    charts_.page_size = 256;
  }

  [[nodiscard]] CameraFrame frame(const PolygonModel& model, const std::function<cv::Vec3d(double, double)>& colour,
                                  double seconds = 1) const {
    return frame(model, camera_, colour, seconds);
  }
  [[nodiscard]] static CameraFrame frame(const PolygonModel& model, const CameraModel& camera,
                                         const std::function<cv::Vec3d(double, double)>& colour, double seconds) {
    CameraFrame result;
    result.camera = camera;
    result.picture.create(camera.height, camera.width, CV_8UC3);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const cv::Vec3d c = colour(x + 0.5, y + 0.5);
        for (int i = 0; i < 3; ++i) result.picture.at<cv::Vec3b>(y, x)[i] = cv::saturate_cast<uchar>(c[i]);
      }
    }
    result.state.stamp = Timestamp::from_seconds(seconds);
    result.state.world_from_part.resize(model.parts().size());
    return result;
  }
  [[nodiscard]] static std::function<cv::Vec3d(double, double)> plain(double grey) {
    return [grey](double, double) { return cv::Vec3d(grey, grey, grey); };
  }

  /// A wall of quads, a floor of small triangles that meets it, and two slanted plates before them that move: three
  /// parts, some charts larger than a patch, most smaller, on several pages.
  [[nodiscard]] static PolygonModel cluttered_room() {
    RawMesh mesh;
    mesh.part_names = {"room", "plate", "box"};
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 3; ++column) {
        add_quad(mesh, -1.2 + 0.8 * column, -0.8 + 0.7 * row, -0.4 + 0.8 * column, -0.1 + 0.7 * row, 2);
      }
    }
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    std::mt19937 random(7);
    const auto jitter = [&] { return 0.06 * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
    constexpr std::uint32_t kRows = 6, kColumns = 8;
    for (std::uint32_t row = 0; row <= kRows; ++row) {
      for (std::uint32_t column = 0; column <= kColumns; ++column) {
        mesh.vertices.emplace_back(-1.2 + 0.3 * column + jitter(), 0.6 + jitter(), 2 - 0.25 * row + jitter());
      }
    }
    for (std::uint32_t row = 0; row < kRows; ++row) {
      for (std::uint32_t column = 0; column < kColumns; ++column) {
        const std::uint32_t a = first + row * (kColumns + 1) + column, b = a + kColumns + 1;
        mesh.faces.push_back({a, b, a + 1});
        mesh.faces.push_back({b, b + 1, a + 1});
      }
    }
    mesh.face_part.assign(mesh.faces.size(), 0);
    const auto plate = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{-0.5, -0.3, 1.0}, {-0.5, 0.2, 1.1}, {0.0, 0.2, 1.4}, {0.0, -0.3, 1.3}});
    mesh.faces.push_back({plate, plate + 1, plate + 2, plate + 3});
    mesh.face_part.push_back(1);
    add_quad(mesh, 0.1, -0.2, 0.4, 0.3, 0.9);
    mesh.face_part.push_back(2);
    return import_as_it_is(mesh);
  }

  /// `count` pictures of the room, whatever may come: sizes, lenses, cameras, and parts that move; stamps mostly rise.
  [[nodiscard]] std::vector<CameraFrame> pictures(const PolygonModel& model, int count, unsigned seed) const {
    std::mt19937 random(seed);
    const auto uniform = [&](double least, double most) {
      return least + (most - least) * static_cast<double>(random()) / 4294967296.0;
    };
    std::vector<CameraFrame> result;
    for (int i = 0; i < count; ++i) {
      CameraModel camera = camera_;
      switch (random() % 6) {
        case 0:
          camera.width = 97;
          camera.height = 61;
          camera.principal_point = {47, 31.4};
          break;
        case 1:
          camera.width = 233;
          camera.height = 170;
          camera.focal_length = {140, 150};
          camera.principal_point = {120, 80};
          break;
        case 2:  // the corners of what it would have to see lie beyond the picture
          camera.distortion_model = DistortionModel::plumb_bob;
          camera.distortion[0] = 0.25;
          break;
        default:
          break;
      }
      const double a = uniform(0, 6), b = uniform(0.05, 0.4), c = uniform(0, 100);
      const auto colour = [=](double u, double v) {
        return cv::Vec3d(c + u, 127 + 120 * std::sin(a + b * u), 127 + 120 * std::sin(b * v - 0.1 * u));
      };
      const bool late = i > 2 && random() % 4 == 0;
      CameraFrame picture = frame(model, camera, colour, late ? i - 1.5 : i + 1.0);
      const glm::dvec3 eye(uniform(-0.4, 0.4), uniform(-0.4, 0.3), uniform(-0.5, 0.5));
      const glm::dvec3 target(uniform(-0.6, 0.6), uniform(-0.2, 0.3), 1.8);
      picture.state.world_from_camera = looking_at(eye, target, {0, -1, 0});
      for (std::size_t part = 1; part < model.parts().size(); ++part) {
        picture.state.world_from_part[part].translation = {uniform(-0.3, 0.3), uniform(-0.2, 0.2), uniform(-0.2, 0.2)};
      }
      result.push_back(std::move(picture));
    }
    return result;
  }

  CameraModel camera_;
  ChartOptions charts_;
  ExtractionOptions options_;
};

}  // namespace foreview
