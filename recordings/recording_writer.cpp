#include <spdlog/spdlog.h>

#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <utility>

#include "foreview/recordings/recording.h"
#include "foreview/recordings/recording_yaml.h"
#include "foreview/scene/disk.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/output_file.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPoseHeader = "# stamp tx ty tz qx qy qz qw (target_from_source: world from camera or part)\n";

/// With all that are missing above it; their names are synced where `is_durable`.
void make_directory(const fs::path& directory, Disk& disk, bool is_durable) {
  fs::path made;
  for (const fs::path& part : directory) {
    const fs::path parent = made;
    made /= part;
    if (part.empty() || part == "/" || part == "." || part == "..") continue;
    const int code = disk.make_directory(made);
    if (code == 0 && is_durable) sync_directory(parent, disk);
    if (code == 0 || code == -EEXIST) continue;
    // Whoever may not write above may still have the rest there.
    std::error_code error;
    if (fs::is_directory(made, error)) continue;
    throw InputError(made.string(), std::string("cannot be created: ") + std::strerror(-code));
  }
}

std::string pose_line(Timestamp stamp, const Pose& pose) {
  std::string line = stamp.to_string();
  const glm::dvec3& t = pose.translation;
  const glm::dquat& q = pose.rotation;
  for (const double number : {t.x, t.y, t.z, q.x, q.y, q.z, q.w}) line += " " + number_text(number);
  return line;
}

std::string joint_header(const std::vector<std::string>& names) {
  std::string line = "stamp";
  for (const std::string& name : names) {
    assert(name.find_first_of(",\r\n") == std::string::npos);
    line += "," + name;
  }
  return line + "\n";
}

}  // namespace

struct RecordingWriter::State {
  struct Unlisted {
    fs::path file;
    std::string line;
  };
  struct Camera {
    fs::path directory;
    CameraModel model;
    std::size_t pictures = 0;
    LineFile list, poses;
    std::vector<Unlisted> unlisted = {};
  };

  void write_lines(void (LineFile::*how)()) {
    for (Camera& camera : cameras) (camera.poses.*how)();
    for (auto& [name, poses] : parts) (poses.*how)();
    if (joints) ((*joints).*how)();
  }

  void commit() {
    if (is_broken) return;
    is_broken = is_durable;  // unless all of it goes well
    for (const Camera& camera : cameras) {
      if (!is_durable || camera.unlisted.empty()) continue;
      for (const Unlisted& picture : camera.unlisted) sync_file(picture.file, *disk);
      sync_directory(camera.directory / "rgb", *disk);
    }
    const auto how = is_durable ? &LineFile::sync : &LineFile::flush;
    write_lines(how);
    for (Camera& camera : cameras) {
      for (const Unlisted& picture : camera.unlisted) camera.list.add(picture.line);
      const std::size_t count = camera.unlisted.size();
      camera.unlisted.clear();
      (camera.list.*how)();
      listed += count;
    }
    is_broken = false;
  }

  Disk* disk = nullptr;
  bool is_durable = false;
  bool is_broken = false;  ///< a commit failed
  fs::path directory;
  std::vector<Camera> cameras;
  std::map<std::string, LineFile> parts;
  std::optional<LineFile> joints;
  std::size_t joint_count = 0;
  std::size_t listed = 0;  ///< since commit() was called last
};

RecordingWriter::RecordingWriter(const fs::path& directory, const Description& description)
    : state_(std::make_unique<State>()) {
  assert(!description.cameras.empty());
  RecordingYaml yaml;
  yaml.name = description.name;
  yaml.stamp_meaning = description.stamp_meaning;
  yaml.exposure = description.exposure;
  yaml.import_options = description.import_options;
  yaml.density = description.density;
  yaml.max_texels = description.max_texels;
  if (!description.scene_file.empty()) yaml.scene_file = description.scene_file;
  if (!description.initial_textures.empty()) yaml.initial_textures = description.initial_textures;
  const bool is_single = description.cameras.size() == 1 && description.cameras[0].name.empty();
  for (const Description::Camera& camera : description.cameras) {
    if (!is_single) yaml.cameras.push_back(camera.name);
  }
  const fs::path yaml_file = directory / "recording.yaml";
  const std::string yaml_text = to_recording_yaml(yaml);
  // What a reader would refuse is refused now, not after an hour of recording.
  static_cast<void>(parse_recording_yaml(yaml_text, yaml_file.string()));

  Disk& disk = description.disk != nullptr ? *description.disk : real_disk();
  const bool is_durable = description.is_durable;
  state_->disk = &disk;
  state_->is_durable = is_durable;
  state_->directory = directory;
  make_directory(directory, disk, is_durable);
  for (const char* name : {"recording.yaml", "camera.yaml", "rgb.txt"}) {
    std::error_code ignored;
    if (fs::exists(directory / name, ignored)) throw InputError(directory.string(), "holds a recording already");
  }
  for (const Description::Camera& camera : description.cameras) {
    const fs::path own = is_single ? directory : directory / camera.name;
    make_directory(own / "rgb", disk, is_durable);
    const fs::path camera_file = own / "camera.yaml";
    const std::string camera_text = to_camera_yaml(camera.model);
    static_cast<void>(parse_camera_yaml(camera_text, camera_file.string()));
    write_file_whole(camera_file, camera_text, disk);
    if (is_durable) {
      sync_file(camera_file, disk);
      sync_directory(own, disk);
    }
    state_->cameras.push_back({own, camera.model, 0, LineFile(own / "rgb.txt", "# stamp file\n", disk),
                               LineFile(own / "groundtruth.txt", kPoseHeader, disk)});
  }
  write_file_whole(yaml_file, yaml_text, disk);
  if (is_durable) {
    sync_file(yaml_file, disk);
    sync_directory(directory, disk);
  }
}

void RecordingWriter::add_picture(std::size_t camera, Timestamp stamp, const cv::Mat& bgr, const std::string& format) {
  State::Camera& target = state_->cameras.at(camera);
  assert(bgr.type() == CV_8UC3 && bgr.cols == target.model.width && bgr.rows == target.model.height);
  assert(format == "png" || format == "jpg");
  std::vector<unsigned char> bytes;
  bool is_encoded = false;
  const std::string where = (target.directory / "rgb").string();
  try {
    is_encoded = format == "png" ? cv::imencode(".png", bgr, bytes)
                                 : cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
  } catch (const cv::Exception& error) {
    throw InputError(where, "a picture cannot be encoded: " + in_quotes(error.err));
  }
  if (!is_encoded) throw InputError(where, "a picture cannot be encoded");
  add_encoded_picture(camera, stamp, bytes, format);
}

void RecordingWriter::add_encoded_picture(std::size_t camera, Timestamp stamp, std::span<const unsigned char> bytes,
                                          const std::string& format) {
  State::Camera& target = state_->cameras.at(camera);
  char name[40];
  std::snprintf(name, sizeof name, "rgb/%06zu.", target.pictures);
  const fs::path file = target.directory / (name + format);
  write_file_whole(file, bytes, *state_->disk);
  ++target.pictures;
  target.unlisted.push_back({file, stamp.to_string() + " " + name + format});
  if (!state_->is_durable) state_->commit();
}

void RecordingWriter::add_camera_pose(std::size_t camera, Timestamp stamp, const Pose& world_from_camera) {
  state_->cameras.at(camera).poses.add(pose_line(stamp, world_from_camera));
}

void RecordingWriter::add_part_pose(const std::string& part, Timestamp stamp, const Pose& world_from_part) {
  auto place = state_->parts.find(part);
  if (place == state_->parts.end() && !state_->is_broken) {
    if (!is_plain_file_name(part)) throw InputError("part " + in_quotes(part), "cannot be the name of a file");
    // Pictures whose part has no pose are not to be listed later.
    state_->is_broken = state_->is_durable;
    make_directory(state_->directory / "parts", *state_->disk, state_->is_durable);
    state_->is_broken = false;
    const fs::path file = state_->directory / "parts" / (part + ".txt");
    place = state_->parts.emplace(part, LineFile(file, kPoseHeader, *state_->disk)).first;
  }
  if (place != state_->parts.end()) place->second.add(pose_line(stamp, world_from_part));
}

void RecordingWriter::set_joint_names(const std::vector<std::string>& names) {
  assert(!state_->joints && !names.empty());
  state_->joints.emplace(state_->directory / "joints.csv", joint_header(names), *state_->disk);
  state_->joint_count = names.size();
}

void RecordingWriter::add_joints(Timestamp stamp, const std::vector<double>& positions) {
  assert(state_->joints && positions.size() == state_->joint_count);
  std::string line = stamp.to_string();
  for (const double position : positions) line += "," + number_text(position);
  state_->joints->add(line);
}

std::size_t RecordingWriter::commit() {
  state_->commit();
  return std::exchange(state_->listed, 0);
}

void RecordingWriter::finish() {
  state_->commit();
}

RecordingWriter::~RecordingWriter() {
  try {
    finish();
  } catch (const std::exception& error) {
    spdlog::error("recording not finished: {}", error.what());
  }
}

}  // namespace foreview
