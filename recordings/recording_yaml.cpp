#include "foreview/recordings/recording_yaml.h"

#include <algorithm>

#include "foreview/recordings/tum_parsing.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/yaml_input.h"

namespace foreview {
namespace {

constexpr std::size_t kMostCameras = 64;
constexpr double kLongestExposure = 60;  // seconds

std::vector<std::string> read_cameras(const YamlMap& yaml) {
  const std::vector<std::string> cameras = yaml.texts("cameras").value_or(std::vector<std::string>());
  if (yaml.has("cameras") && cameras.empty()) yaml.fail("cameras", "is empty; leave it out for a single camera");
  if (cameras.size() > kMostCameras) yaml.fail("cameras", "lists more than " + std::to_string(kMostCameras));
  for (auto camera = cameras.begin(); camera != cameras.end(); ++camera) {
    if (!is_plain_file_name(*camera)) {
      yaml.fail("cameras", in_quotes(*camera) + " cannot be the name of a sub-directory");
    }
    if (std::find(cameras.begin(), camera, *camera) != camera) {
      yaml.fail("cameras", in_quotes(*camera) + " is there twice");
    }
  }
  return cameras;
}

void read_stamp(const YamlMap& yaml, RecordingYaml& result) {
  if (const std::optional<std::string> exposure = yaml.text("exposure")) {
    try {
      result.exposure = Duration::parse(*exposure, "exposure");
    } catch (const InputError&) {
      yaml.fail("exposure", in_quotes(*exposure) + " is no duration; expected as in 10ms");
    }
    if (!(result.exposure.nanoseconds >= 0 && result.exposure.seconds() <= kLongestExposure)) {
      yaml.fail("exposure", "is " + printable(*exposure) + "; expected 0 to " + number_text(kLongestExposure) + " s");
    }
  }
  const std::string stamp = yaml.text("stamp").value_or("middle_of_exposure");
  if (stamp == "middle_of_exposure") return;
  if (stamp != "start_of_exposure") {
    yaml.fail("stamp", "is " + in_quotes(stamp) + "; expected start_of_exposure or middle_of_exposure");
  }
  if (!yaml.has("exposure")) yaml.fail("stamp", "start_of_exposure needs to know the exposure, as in exposure: 10ms");
  result.stamp_meaning = StampMeaning::start_of_exposure;
}

std::optional<std::string> read_path(const YamlMap& yaml, const char* key) {
  const std::optional<std::string> path = yaml.text(key);
  if (path && !stays_inside(*path)) {
    yaml.fail(key, in_quotes(*path) + " leads out of the recording; expected a path relative to it");
  }
  return path;
}

void read_scene(const YamlMap& yaml, RecordingYaml& result) {
  yaml.allow_only({"model", "scale", "merge", "max_merged_extent", "planarity_tolerance", "weld_distance", "backdrop",
                   "backdrop_texels_per_radian", "backdrop_max_texels"});
  ImportOptions& options = result.import_options;
  result.scene_file = read_path(yaml, "model");
  options.scale = yaml.number("scale", 1e-6, 1e6).value_or(options.scale);
  options.merge_coplanar = yaml.flag("merge").value_or(options.merge_coplanar);
  options.max_merged_extent = yaml.number("max_merged_extent", 0, 1e6).value_or(options.max_merged_extent);
  options.planarity_tolerance = yaml.number("planarity_tolerance", 0, 1e3).value_or(options.planarity_tolerance);
  options.weld_distance = yaml.number("weld_distance", 0, 1e3).value_or(options.weld_distance);
  options.backdrop = yaml.flag("backdrop").value_or(options.backdrop);
  options.backdrop_texels_per_radian =
      yaml.number("backdrop_texels_per_radian", 1, 1e5).value_or(options.backdrop_texels_per_radian);
  options.backdrop_max_texels = yaml.integer("backdrop_max_texels", 1, 16384).value_or(options.backdrop_max_texels);
}

void read_textures(const YamlMap& yaml, RecordingYaml& result) {
  yaml.allow_only({"density", "max_texels", "initial"});
  result.density = yaml.number("density", 1e-3, 1e6);
  result.max_texels = yaml.integer("max_texels", 1, 16384);
  result.initial_textures = read_path(yaml, "initial");
}

}  // namespace

bool is_plain_file_name(const std::string& name) {
  constexpr std::size_t kLongestName = 200;  // file systems take 255 bytes, and endings are added
  if (name.empty() || name.front() == '.' || name.size() > kLongestName) return false;
  return std::none_of(name.begin(), name.end(), [](char c) {
    return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
}

RecordingYaml parse_recording_yaml(const std::string& text, const std::string& where) {
  const YamlMap yaml = YamlMap::parse(text, where);
  yaml.allow_only({"name", "cameras", "stamp", "exposure", "scene", "textures"});
  RecordingYaml result;
  result.name = yaml.text("name").value_or("");
  result.cameras = read_cameras(yaml);
  read_stamp(yaml, result);
  if (const std::optional<YamlMap> scene = yaml.map("scene")) read_scene(*scene, result);
  if (const std::optional<YamlMap> textures = yaml.map("textures")) read_textures(*textures, result);
  return result;
}

std::string to_recording_yaml(const RecordingYaml& recording) {
  std::string yaml = "name: " + yaml_quoted(recording.name) + "\n";
  if (!recording.cameras.empty()) {
    std::string list;
    for (const std::string& camera : recording.cameras) list += (list.empty() ? "" : ", ") + yaml_quoted(camera);
    yaml += "cameras: [" + list + "]\n";
  }
  if (recording.stamp_meaning == StampMeaning::start_of_exposure) yaml += "stamp: start_of_exposure\n";
  if (recording.exposure.nanoseconds != 0) {
    yaml += "exposure: " + Timestamp{recording.exposure.nanoseconds}.to_string() + "s\n";
  }

  const ImportOptions& options = recording.import_options;
  const ImportOptions defaults;
  std::string scene;
  const auto number = [&](const char* key, double value, double standard) {
    if (value != standard) scene += std::string("  ") + key + ": " + number_text(value) + "\n";
  };
  const auto flag = [&](const char* key, bool value, bool standard) {
    if (value != standard) scene += std::string("  ") + key + ": " + (value ? "true" : "false") + "\n";
  };
  if (recording.scene_file) scene += "  model: " + yaml_quoted(*recording.scene_file) + "\n";
  number("scale", options.scale, defaults.scale);
  flag("merge", options.merge_coplanar, defaults.merge_coplanar);
  number("max_merged_extent", options.max_merged_extent, defaults.max_merged_extent);
  number("planarity_tolerance", options.planarity_tolerance, defaults.planarity_tolerance);
  number("weld_distance", options.weld_distance, defaults.weld_distance);
  flag("backdrop", options.backdrop, defaults.backdrop);
  number("backdrop_texels_per_radian", options.backdrop_texels_per_radian, defaults.backdrop_texels_per_radian);
  number("backdrop_max_texels", options.backdrop_max_texels, defaults.backdrop_max_texels);
  if (!scene.empty()) yaml += "scene:\n" + scene;

  std::string textures;
  if (recording.density) textures += "  density: " + number_text(*recording.density) + "\n";
  if (recording.max_texels) textures += "  max_texels: " + std::to_string(*recording.max_texels) + "\n";
  if (recording.initial_textures) textures += "  initial: " + yaml_quoted(*recording.initial_textures) + "\n";
  if (!textures.empty()) yaml += "textures:\n" + textures;
  return yaml;
}

}  // namespace foreview
