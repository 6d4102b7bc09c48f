#include <algorithm>
#include <set>
#include <system_error>

#include "foreview/recordings/damage_log.h"
#include "foreview/recordings/joints_parsing.h"
#include "foreview/recordings/recording.h"
#include "foreview/recordings/recording_yaml.h"
#include "foreview/recordings/tum_parsing.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/yaml_input.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTextBytes = std::size_t{256} << 20;  // 3 million poses
constexpr std::size_t kMostParts = 10000;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

fs::path required_file(const fs::path& directory, const std::string& relative, const fs::path& yaml, const char* key) {
  fs::path file = directory / relative;
  if (!is_file(file)) throw InputError(yaml.string(), std::string(key) + ": no such file: " + file.string());
  return file;
}

}  // namespace

/// Assembles a Recording from its directory.
class RecordingReader {
 public:
  explicit RecordingReader(const fs::path& directory) : directory_(directory) {}

  Recording read() {
    std::error_code error;
    if (!is_there(directory_)) throw InputError(directory_.string(), "no such directory; expected a recording");
    if (!fs::is_directory(directory_, error)) {
      throw InputError(directory_.string(), "is not a directory; expected the directory of a recording");
    }
    recording_.directory_ = directory_;
    const fs::path yaml_file = directory_ / "recording.yaml";
    RecordingYaml yaml;
    if (is_there(yaml_file)) {
      yaml = parse_recording_yaml(read_input_file(yaml_file, YamlMap::kMaxBytes), yaml_file.string());
    }
    recording_.name_ = yaml.name.empty() ? default_name() : yaml.name;
    shift_ =
        yaml.stamp_meaning == StampMeaning::start_of_exposure ? Duration{yaml.exposure.nanoseconds / 2} : Duration{};
    if (yaml.cameras.empty()) {
      read_camera(directory_, "");
    } else {
      for (const std::string& name : yaml.cameras) read_camera(directory_ / name, name);
    }
    find_scene(yaml, yaml_file);
    recording_.import_options_ = yaml.import_options;
    recording_.proposed_density_ = yaml.density;
    recording_.proposed_max_texels_ = yaml.max_texels;
    if (yaml.initial_textures) {
      const fs::path textures = directory_ / *yaml.initial_textures;
      if (!is_there(textures)) {
        throw InputError(yaml_file.string(), "textures.initial: no such directory: " + textures.string());
      }
      recording_.initial_textures_ = textures;
    }
    read_parts();
    const fs::path joints = directory_ / "joints.csv";
    if (is_there(joints)) {
      recording_.joints_ = parse_joints(read_input_file(joints, kMostTextBytes), joints.string(), damage_);
    }
    recording_.damage_ = damage_.counts();
    damage_.report(recording_.name_);
    return std::move(recording_);
  }

 private:
  std::string default_name() const {
    // "recordings/kitchen/" and "." end in nothing and in a dot.
    const fs::path whole = fs::absolute(directory_).lexically_normal();
    const fs::path last = whole.has_filename() ? whole.filename() : whole.parent_path().filename();
    return last.empty() ? "recording" : last.string();
  }

  void read_camera(const fs::path& directory, const std::string& name) {
    Recording::Camera camera;
    camera.model = read_camera_yaml(directory / "camera.yaml");
    if (!name.empty()) camera.model.name = name;
    if (camera.model.name.empty()) camera.model.name = "camera";
    camera.name = camera.model.name;

    const fs::path poses = directory / "groundtruth.txt";
    camera.world_from_camera = read_poses(poses);
    const fs::path list = directory / "rgb.txt";
    std::vector<ListedPicture> listed =
        parse_picture_list(read_input_file(list, kMostTextBytes), list.string(), damage_);
    std::set<std::string> stems;
    for (const ListedPicture& picture : listed) {
      const std::string place = list.string() + ":" + std::to_string(picture.line);
      fs::path file = directory / picture.file;
      if (!is_file(file)) {
        damage_.note(&RecordingDamage::pictures_missing, place, "no file " + in_quotes(file.string()));
        continue;
      }
      const Timestamp stamp = picture.stamp + shift_;
      if (stamp < camera.world_from_camera.first() || stamp > camera.world_from_camera.last()) {
        damage_.note(&RecordingDamage::pictures_without_pose, place,
                     stamp.to_string() + " is outside the recorded poses, " +
                         camera.world_from_camera.first().to_string() + " to " +
                         camera.world_from_camera.last().to_string());
        continue;
      }
      std::string stem = file.stem().string();
      if (!stems.insert(stem).second) {
        stem += "-" + std::to_string(camera.pictures.size());
        stems.insert(stem);
      }
      camera.pictures.push_back({stamp, std::move(file), std::move(stem)});
    }
    if (camera.pictures.empty()) {
      const std::string summary = damage_.summary();
      throw InputError(list.string(), "not one usable picture; expected lines 'stamp file'" +
                                          (summary.empty() ? "" : " (" + summary + ")"));
    }
    recording_.cameras_.push_back(std::move(camera));
  }

  Trajectory read_poses(const fs::path& file) {
    Trajectory trajectory = parse_trajectory(read_input_file(file, kMostTextBytes), file.string(), damage_);
    if (trajectory.empty()) {
      const std::string summary = damage_.summary();
      throw InputError(file.string(), "not one usable pose; expected lines 'stamp tx ty tz qx qy qz qw'" +
                                          (summary.empty() ? "" : " (" + summary + ")"));
    }
    return trajectory;
  }

  void find_scene(const RecordingYaml& yaml, const fs::path& yaml_file) {
    if (yaml.scene_file) {
      recording_.scene_file_ = required_file(directory_, *yaml.scene_file, yaml_file, "scene.model");
      return;
    }
    for (const char* ending : {"obj", "ply", "glb", "stl", "off", "dae"}) {
      const fs::path file = directory_ / (std::string("scene.") + ending);
      if (!is_file(file)) continue;
      recording_.scene_file_ = file;
      return;
    }
  }

  void read_parts() {
    const fs::path directory = directory_ / "parts";
    std::error_code error;
    if (!fs::is_directory(directory, error)) return;
    for (fs::directory_iterator entry(directory, error), end; entry != end; entry.increment(error)) {
      const fs::path& file = entry->path();
      if (file.extension() != ".txt") continue;
      if (recording_.parts_.size() == kMostParts) {
        throw InputError(directory.string(), "holds more than " + std::to_string(kMostParts) + " parts");
      }
      recording_.parts_[file.stem().string()] = read_poses(file);
    }
    if (error) throw InputError(directory.string(), "cannot be read: " + error.message());
  }

  fs::path directory_;
  Recording recording_;
  DamageLog damage_;
  Duration shift_;
};

Recording Recording::open(const std::filesystem::path& directory) {
  return RecordingReader(directory).read();
}

}  // namespace foreview
