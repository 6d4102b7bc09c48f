#include "oracle/random_scene.h"

#include <glm/geometric.hpp>
#include <numbers>
#include <random>

namespace foreview::oracle {
namespace {

/// std::uniform_real_distribution may differ between libraries; this does not.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0); }
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 v(in(-1, 1), in(-1, 1), in(-1, 1));
      if (glm::length(v) > 0.1 && glm::length(v) < 1) return glm::normalize(v);
    }
  }

 private:
  std::mt19937 engine_;
};

void add_face(RawMesh& mesh, const std::vector<glm::dvec3>& corners, std::uint32_t part) {
  std::vector<std::uint32_t> face;
  for (const glm::dvec3& corner : corners) {
    face.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(corner);
  }
  mesh.faces.push_back(face);
  mesh.face_part.push_back(part);
}

void add_box(RawMesh& mesh, const glm::dvec3& centre, const glm::dvec3& half, double turn, std::uint32_t part) {
  const Pose pose{glm::angleAxis(turn, glm::dvec3(0, 1, 0)), centre};
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(pose *
                            (half * glm::dvec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)));
  }
  for (const auto& face : {std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}, std::array{0, 1, 5, 4},
                           std::array{2, 6, 7, 3}, std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}}) {
    std::vector<std::uint32_t> corners;
    corners.reserve(face.size());
    for (const int corner : face) corners.push_back(first + static_cast<std::uint32_t>(corner));
    mesh.faces.push_back(corners);
    mesh.face_part.push_back(part);
  }
}

/// A zigzag of triangles that share edges, bent so that neighbours differ in depth.
void add_strip(RawMesh& mesh, const glm::dvec3& start, Random& random) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  constexpr std::uint32_t kPairs = 5;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const glm::dvec3 base = start + glm::dvec3(0.25 * i, 0, random.in(-0.12, 0.12));
    mesh.vertices.push_back(base);
    mesh.vertices.push_back(base + glm::dvec3(random.in(-0.05, 0.05), 0.4, random.in(-0.15, 0.15)));
  }
  for (std::uint32_t i = 0; i + 1 < kPairs; ++i) {
    const std::uint32_t a = first + 2 * i;
    // Seen from -z, y down: counter-clockwise.
    mesh.faces.push_back({a, a + 1, a + 2});
    mesh.faces.push_back({a + 2, a + 1, a + 3});
    mesh.face_part.insert(mesh.face_part.end(), 2, 0);
  }
}

void add_convex(RawMesh& mesh, Random& random) {
  const glm::dvec3 centre(random.in(-1.2, 1.2), random.in(-0.9, 0.9), random.in(0.5, 3.5));
  const glm::dvec3 normal = glm::normalize(random.direction() + glm::dvec3(0, 0, -0.7));
  const glm::dvec3 x = glm::normalize(glm::cross(normal, glm::dvec3(0.3, 0.9, 0.1)));
  const glm::dvec3 y = glm::cross(normal, x);
  const double rx = random.in(0.05, 0.5), ry = random.in(0.05, 0.5);
  const int corners = 3 + static_cast<int>(random.in(0, 4.99));
  const double start = random.in(0, 6);
  std::vector<glm::dvec3> face;
  for (int i = 0; i < corners; ++i) {
    const double angle = start + 2 * std::numbers::pi * (i + random.in(-0.3, 0.3)) / corners;
    face.push_back(centre + x * (rx * std::cos(angle)) + y * (ry * std::sin(angle)));
  }
  add_face(mesh, face, 0);
}

cv::Mat noisy_picture(const CameraModel& camera, Random& random) {
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double smooth = c == 0 ? 255.0 * x / camera.width : c == 1 ? 255.0 * y / camera.height : 128;
        picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<unsigned char>(smooth + random.in(-60, 60));
      }
    }
  }
  return picture;
}

CameraModel random_camera(DistortionModel distortion, Random& random) {
  CameraModel camera;
  camera.width = 167;
  camera.height = 122;
  camera.focal_length = {random.in(100, 180), random.in(100, 180)};
  camera.principal_point = {random.in(70, 95), random.in(50, 70)};
  camera.distortion_model = distortion;
  if (distortion == DistortionModel::plumb_bob) {
    // Pincushion half the time: then the undistorted picture reaches beyond the lens's.
    const double k1 = random.in(0, 1) < 0.5 ? random.in(0.05, 0.2) : random.in(-0.3, -0.05);
    camera.distortion = {k1, random.in(-0.05, 0.08), 0.002, -0.0015, 0.01, 0, 0, 0};
  }
  if (distortion == DistortionModel::fisheye) camera.distortion = {-0.02, 0.006, -0.003, 0.0005, 0, 0, 0, 0};
  return camera;
}

CaptureState random_state(Random& random, std::size_t parts, Timestamp stamp) {
  CaptureState state;
  state.stamp = stamp;
  state.world_from_camera = {glm::angleAxis(random.in(-0.15, 0.15), random.direction()),
                             glm::dvec3(random.in(-0.1, 0.1), random.in(-0.1, 0.1), random.in(-0.1, 0.1))};
  state.world_from_part.assign(parts, Pose());
  state.world_from_part[1] = {glm::angleAxis(random.in(-0.5, 0.5), random.direction()),
                              glm::dvec3(random.in(-0.3, 0.3), random.in(-0.2, 0.2), random.in(-0.1, 0.3))};
  return state;
}

}  // namespace

RandomScene random_scene(unsigned seed, DistortionModel distortion, bool backdrop) {
  Random random(seed);
  RawMesh mesh;
  mesh.part_names = {"room", "mover"};
  add_face(mesh, {{-2, 0.8, -1}, {2, 0.8, -1}, {2, 0.8, 5}, {-2, 0.8, 5}}, 0);
  // The floor as seen from above (y is down) must be counter-clockwise there.
  add_face(mesh, {{-2, -1.5, 4.5}, {-2, 0.8, 4.5}, {2.5, 0.8, 4.2}, {2.5, -1.5, 4.2}}, 0);
  add_strip(mesh, {-0.9, -0.5, 2.2}, random);
  for (int i = 0; i < 6; ++i) add_convex(mesh, random);
  add_box(mesh, {random.in(-0.3, 0.3), 0.2, 1.6}, {0.15, 0.12, 0.2}, random.in(0, 1.5), 1);

  ImportOptions options;
  options.merge_coplanar = false;
  options.weld_distance = 1e-9;
  options.backdrop = backdrop;
  options.backdrop_texels_per_radian = 60;
  options.backdrop_max_texels = 64;
  RandomScene scene;
  scene.model = build_polygon_model(mesh, options);
  scene.frame.camera = random_camera(distortion, random);
  scene.frame.state = random_state(random, scene.model.parts().size(), Timestamp{1'000'000});
  scene.frame.picture = noisy_picture(scene.frame.camera, random);
  return scene;
}

CameraFrame moved(const RandomScene& scene, unsigned seed, Timestamp stamp) {
  Random random(seed);
  CameraFrame frame = scene.frame;
  frame.state = random_state(random, scene.model.parts().size(), stamp);
  frame.picture = noisy_picture(frame.camera, random);
  return frame;
}

}  // namespace foreview::oracle
