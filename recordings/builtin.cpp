#include "foreview/recordings/builtin.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>
#include <system_error>
#include <thread>

#include "foreview/recordings/synthetic/noise.h"
#include "foreview/recordings/synthetic/ordered_work.h"
#include "foreview/recordings/synthetic/renderer.h"
#include "foreview/recordings/synthetic/sensor_noise.h"
#include "foreview/recordings/synthetic/site.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;
using Progress = std::function<void(std::size_t, std::size_t)>;

constexpr int kVersion = 2;  // raise whenever the same options give other files: caches are then made anew
constexpr const char* kMarkerFile = "generated.txt";
constexpr std::int64_t kFirstStamp = 1'000'000'000'000;  // nanoseconds; not zero, as no real stream begins there
constexpr double kNoiseSigma = 2.4, kNoiseCommon = 0.5;  // after JPEG, at least 2/255 are left in every channel

synthetic::Site make_site(const std::string& name) {
  if (name == "workcell") return synthetic::make_workcell_site();
  if (name == "object") return synthetic::make_object_site();
  if (name == "cube") return synthetic::make_cube_site();
  throw InputError("built-in recording", "there is no '" + name + "'; expected workcell, object or cube");
}

void require(bool holds, const std::string& option, const std::string& expected) {
  if (!holds) throw InputError(option, "expected " + expected);
}

/// NaN fails every one of these.
void check(const GenerateOptions& o, std::size_t instants) {
  require(o.scale >= 0.02 && o.scale <= 4, "scale", "a number from 0.02 to 4");
  require(o.first_picture < instants, "first picture",
          "a number below the recording's " + std::to_string(instants) + " pictures");
  require(!o.pictures || *o.pictures > 0, "pictures", "at least one");
  const auto within = [](double x, double limit) { return std::abs(x) <= limit; };
  require(within(o.errors.pose_degrees, 90), "pose error", "at most 90 degrees");
  require(within(o.errors.pose_millimetres, 10'000), "pose error", "at most 10000 mm");
  require(within(o.errors.focal_length_percent, 90), "focal length error", "at most 90 %");
  require(within(o.errors.distortion_percent, 1000), "distortion error", "at most 1000 %");
  require(within(o.errors.model_millimetres, 10'000), "model error", "at most 10000 mm");
}

std::size_t picture_count(const GenerateOptions& o, std::size_t instants) {
  const std::size_t rest = instants - o.first_picture;
  return o.pictures ? std::min(*o.pictures, rest) : rest;
}

/// Everything that decides the files' bytes, in one line.
std::string describe(const GenerateOptions& o, std::size_t count) {
  char text[400];
  std::snprintf(
      text, sizeof text,
      "%s version %d first %zu pictures %zu scale %.9g pose %.9g deg %.9g mm focal %.9g %% distortion %.9g %% "
      "model %.9g mm",
      o.name.c_str(), kVersion, o.first_picture, count, o.scale, o.errors.pose_degrees, o.errors.pose_millimetres,
      o.errors.focal_length_percent, o.errors.distortion_percent, o.errors.model_millimetres);
  return text;
}

std::string marker_text(const std::string& description, bool complete) {
  return "foreview built-in recording\n" + description + "\n" + (complete ? "complete" : "incomplete") + "\n";
}

std::string read_marker(const fs::path& directory) {
  std::ifstream file(directory / kMarkerFile, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

CameraModel scaled(const CameraModel& camera, double scale) {
  CameraModel result = camera;
  result.width = std::max(8, static_cast<int>(std::lround(camera.width * scale)));
  result.height = std::max(8, static_cast<int>(std::lround(camera.height * scale)));
  const glm::dvec2 factor{static_cast<double>(result.width) / camera.width,
                          static_cast<double>(result.height) / camera.height};
  result.focal_length *= factor;
  result.principal_point *= factor;
  return result;
}

CameraModel falsified(const CameraModel& camera, const InjectedErrors& errors) {
  CameraModel result = camera;
  result.focal_length *= 1 + errors.focal_length_percent / 100;
  for (double& k : result.distortion) k *= 1 + errors.distortion_percent / 100;
  return result;
}

/// The head's pan encoder is off: every camera is turned about the world's vertical through itself. (About an axis
/// fixed in the camera instead, the error would swing round with every turn of the head, and textures taken before and
/// after would disagree by more than the ghosts that this error is to provoke.)
Pose falsified(const Pose& world_from_camera, const InjectedErrors& errors) {
  const glm::dquat pan = glm::angleAxis(errors.pose_degrees * std::numbers::pi / 180, glm::dvec3(0, 0, 1));
  const glm::dvec3 direction_in_camera = glm::normalize(glm::dvec3(0.61, -0.42, 0.67));
  return {glm::normalize(pan * world_from_camera.rotation),
          world_from_camera * (direction_in_camera * (errors.pose_millimetres / 1000))};
}

/// A fixed direction for the n-th thing.
glm::dvec3 direction_of(int n) {
  const double z = 2.0 * synthetic::chance(n, 1, 77) - 1, turn = 2 * std::numbers::pi * synthetic::chance(n, 2, 77);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

RawMesh model_of(const synthetic::Site& site, double error_millimetres) {
  RawMesh mesh = site.mesh;
  mesh.faces.resize(site.model_faces);
  mesh.face_part.resize(site.model_faces);
  mesh.vertices.resize(site.model_vertices);
  if (error_millimetres == 0) return mesh;
  std::vector<char> displaced(mesh.vertices.size(), 0);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::uint32_t part = mesh.face_part[f];
    const int object = site.faces[f].free_object;
    if (object < 0 && site.part_moves[part] == 0) continue;
    const glm::dvec3 by = direction_of(object >= 0 ? object : -1 - static_cast<int>(part)) * (error_millimetres / 1000);
    for (const std::uint32_t v : mesh.faces[f]) {
      if (displaced[v] == 0) mesh.vertices[v] += by;
      displaced[v] = 1;
    }
  }
  return mesh;
}

/// Takes an unfinished recording of ours away; refuses to touch anything else.
void clear(const fs::path& directory) {
  std::error_code error;
  for (const char* name : {"recording.yaml", "camera.yaml", "rgb.txt", "groundtruth.txt", "scene.obj", "joints.csv"}) {
    fs::remove(directory / name, error);
  }
  for (const char* name : {"rgb", "left", "right", "parts"}) fs::remove_all(directory / name, error);
}

/// Prepares the directory. False: the same recording is there already, whole.
bool prepare(const fs::path& directory, const std::string& description) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw InputError(directory.string(), "cannot be created: " + error.message());
  const std::string marker = read_marker(directory);
  if (marker == marker_text(description, true)) return false;
  const bool unfinished = marker.ends_with("\nincomplete\n");
  if (!unfinished && !fs::is_empty(directory, error)) {
    throw InputError(directory.string(), marker.empty() ? "is not empty; expected a new or empty directory"
                                                        : "holds another recording; expected a new or empty directory");
  }
  write_file_whole(directory / kMarkerFile, marker_text(description, false));
  clear(directory);
  return true;
}

/// Other processes that want the same recording wait here.
class Lock {
 public:
  Lock(const fs::path& file, const std::function<void()>& while_waiting)
      : descriptor_(::open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644)) {
    if (descriptor_ < 0) throw InputError(file.string(), "cannot be created");
    while (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      try {
        while_waiting();
      } catch (...) {
        ::close(descriptor_);
        throw;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  ~Lock() { ::close(descriptor_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int descriptor_;
};

}  // namespace

struct SyntheticSite::State {
  explicit State(const std::string& name) : site(make_site(name)), model(model_of(site, 0)), renderer(site) {}
  synthetic::Site site;
  RawMesh model;
  synthetic::Renderer renderer;
};

SyntheticSite::SyntheticSite(const std::string& name) : state_(std::make_unique<State>(name)) {}
SyntheticSite::~SyntheticSite() = default;

const RawMesh& SyntheticSite::mesh() const {
  return state_->model;
}
std::size_t SyntheticSite::instants() const {
  return state_->site.instants;
}
Timestamp SyntheticSite::stamp(std::size_t instant) const {
  return {kFirstStamp + static_cast<std::int64_t>(instant) * state_->site.period_nanoseconds};
}
std::size_t SyntheticSite::camera_count() const {
  return state_->site.cameras.size();
}
const CameraModel& SyntheticSite::camera(std::size_t index) const {
  return state_->site.cameras.at(index);
}
Pose SyntheticSite::world_from_camera(std::size_t camera, Timestamp stamp) const {
  return state_->site.world_from_camera(camera, (stamp - Timestamp{kFirstStamp}).seconds());
}
std::vector<Pose> SyntheticSite::world_from_part(Timestamp stamp) const {
  return state_->site.world_from_part((stamp - Timestamp{kFirstStamp}).seconds());
}
cv::Mat SyntheticSite::render(const CameraModel& camera, const Pose& world_from_camera, Timestamp stamp) const {
  return state_->renderer.render(camera, world_from_camera, (stamp - Timestamp{kFirstStamp}).seconds());
}
std::vector<std::uint32_t> SyntheticSite::visible_polygons(const CameraModel& camera, const Pose& world_from_camera,
                                                           Timestamp stamp) const {
  std::vector<std::uint32_t> faces =
      state_->renderer.visible_faces(camera, world_from_camera, (stamp - Timestamp{kFirstStamp}).seconds());
  std::erase_if(faces, [&](std::uint32_t f) { return f >= state_->site.model_faces; });
  return faces;
}

std::vector<std::string> builtin_recording_names() {
  return {"workcell", "object", "cube"};
}

void generate_recording(const GenerateOptions& options, const fs::path& directory, const Progress& progress) {
  const synthetic::Site site = make_site(options.name);
  check(options, site.instants);
  const std::size_t instants = picture_count(options, site.instants), cameras = site.cameras.size();
  const std::string description = describe(options, instants);
  if (!prepare(directory, description)) return;

  std::vector<CameraModel> lenses;
  RecordingWriter::Description what;
  what.name = site.name;
  what.scene_file = "scene.obj";
  what.import_options.merge_coplanar = false;
  what.import_options.backdrop = !site.closed_room;
  what.density = 500;
  what.max_texels = 256;
  for (const CameraModel& camera : site.cameras) {
    lenses.push_back(scaled(camera, options.scale));
    what.cameras.push_back({camera.name, falsified(lenses.back(), options.errors)});
  }
  write_obj(model_of(site, options.errors.model_millimetres), directory / "scene.obj");
  RecordingWriter writer(directory, what);
  if (!site.joint_names.empty()) writer.set_joint_names(site.joint_names);

  const synthetic::Renderer renderer(site);
  const auto seconds = [&](std::size_t instant) {
    return static_cast<double>(static_cast<std::int64_t>(instant) * site.period_nanoseconds) * 1e-9;
  };
  const auto make = [&](std::size_t job) {
    const std::size_t instant = options.first_picture + job / cameras, camera = job % cameras;
    const double t = seconds(instant);
    cv::Mat picture = renderer.render(lenses[camera], site.world_from_camera(camera, t), t);
    synthetic::add_sensor_noise(picture, kNoiseSigma, kNoiseCommon, static_cast<std::uint32_t>(instant * 16 + camera));
    return picture;
  };
  const auto take = [&](std::size_t job, const cv::Mat& picture) {
    const std::size_t instant = options.first_picture + job / cameras, camera = job % cameras;
    const double t = seconds(instant);
    const Timestamp stamp{kFirstStamp + static_cast<std::int64_t>(instant) * site.period_nanoseconds};
    if (camera == 0) {
      const std::vector<Pose> parts = site.world_from_part(t);
      for (std::size_t p = 0; p < parts.size(); ++p) {
        if (site.part_moves[p] != 0) writer.add_part_pose(site.mesh.part_names[p], stamp, parts[p]);
      }
      if (site.joints) writer.add_joints(stamp, site.joints(t));
    }
    writer.add_camera_pose(camera, stamp, falsified(site.world_from_camera(camera, t), options.errors));
    writer.add_picture(camera, stamp, picture);
    if (progress) progress(job + 1, instants * cameras);
  };
  if (progress) progress(0, instants * cameras);
  synthetic::make_in_order(instants * cameras, make, take);
  writer.finish();
  write_file_whole(directory / kMarkerFile, marker_text(description, true));
}

fs::path recording_cache_directory() {
  const auto variable = [](const char* name) -> fs::path {
    const char* const value = std::getenv(name);
    return value != nullptr ? value : "";
  };
  if (fs::path own = variable("FOREVIEW_CACHE"); !own.empty()) return own;
  if (fs::path common = variable("XDG_CACHE_HOME"); !common.empty()) return common / "foreview";
  if (const fs::path home = variable("HOME"); !home.empty()) return home / ".cache" / "foreview";
  throw InputError("cache of built-in recordings", "no place known; set FOREVIEW_CACHE to a directory");
}

fs::path cached_recording(const GenerateOptions& options, const Progress& progress) {
  const synthetic::Site site = make_site(options.name);
  check(options, site.instants);
  const std::size_t instants = picture_count(options, site.instants);
  const std::string description = describe(options, instants);
  // FNV-1a: short, and the same on every machine.
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : description) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  char suffix[40];
  std::snprintf(suffix, sizeof suffix, "-v%d-%016llx", kVersion, static_cast<unsigned long long>(hash));
  const fs::path root = recording_cache_directory();
  fs::path directory = root / (options.name + suffix);
  if (read_marker(directory) == marker_text(description, true)) return directory;
  std::error_code error;
  fs::create_directories(root, error);
  if (error) throw InputError(root.string(), "cannot be created: " + error.message());
  const Lock lock(root / (options.name + suffix + ".lock"), [&] {
    if (progress) progress(0, instants * site.cameras.size());
  });
  generate_recording(options, directory, progress);
  return directory;
}

}  // namespace foreview
