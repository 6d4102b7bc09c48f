#include "foreview/recordings/recording_yaml.h"

#include <gtest/gtest.h>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

std::string error_of(const std::string& text) {
  try {
    static_cast<void>(parse_recording_yaml(text, "recording.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RecordingYaml, EverythingHasADefault) {
  for (const char* text : {"", "# nothing\n", "name: kitchen\n", "scene: {}\ntextures: {}\n"}) {
    const RecordingYaml yaml = parse_recording_yaml(text, "recording.yaml");
    EXPECT_TRUE(yaml.cameras.empty());
    EXPECT_EQ(yaml.stamp_meaning, StampMeaning::middle_of_exposure);
    EXPECT_FALSE(yaml.scene_file || yaml.density || yaml.max_texels || yaml.initial_textures);
    EXPECT_EQ(yaml.import_options.scale, 1);
    EXPECT_TRUE(yaml.import_options.backdrop);
  }
}

TEST(RecordingYaml, ReadsEveryKey) {
  const RecordingYaml yaml = parse_recording_yaml(
      "name: Work cell\ncameras: [left, right]\nstamp: start_of_exposure\nexposure: 12.5ms\n"
      "scene:\n  model: models/cell.obj\n  scale: 0.001\n  merge: no\n  max_merged_extent: 2\n"
      "  planarity_tolerance: 0.01\n  weld_distance: 0.0001\n  backdrop: false\n"
      "  backdrop_texels_per_radian: 300\n  backdrop_max_texels: 128\n"
      "textures: {density: 200, max_texels: 512, initial: start.textures}\n",
      "recording.yaml");
  EXPECT_EQ(yaml.name, "Work cell");
  EXPECT_EQ(yaml.cameras, (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(yaml.stamp_meaning, StampMeaning::start_of_exposure);
  EXPECT_EQ(yaml.exposure.nanoseconds, 12500000);
  EXPECT_EQ(yaml.scene_file, "models/cell.obj");
  EXPECT_EQ(yaml.import_options.scale, 0.001);
  EXPECT_FALSE(yaml.import_options.merge_coplanar);
  EXPECT_EQ(yaml.import_options.max_merged_extent, 2);
  EXPECT_EQ(yaml.import_options.planarity_tolerance, 0.01);
  EXPECT_EQ(yaml.import_options.weld_distance, 0.0001);
  EXPECT_FALSE(yaml.import_options.backdrop);
  EXPECT_EQ(yaml.import_options.backdrop_texels_per_radian, 300);
  EXPECT_EQ(yaml.import_options.backdrop_max_texels, 128);
  EXPECT_EQ(yaml.density, 200);
  EXPECT_EQ(yaml.max_texels, 512);
  EXPECT_EQ(yaml.initial_textures, "start.textures");

  const RecordingYaml again = parse_recording_yaml(to_recording_yaml(yaml), "written");
  EXPECT_EQ(to_recording_yaml(again), to_recording_yaml(yaml));
  EXPECT_EQ(again.exposure, yaml.exposure);
  EXPECT_EQ(again.import_options.weld_distance, yaml.import_options.weld_distance);
  EXPECT_EQ(again.cameras, yaml.cameras);
  EXPECT_EQ(again.initial_textures, yaml.initial_textures);
}

TEST(RecordingYaml, NamesLineKeyAndWhatIsAllowed) {
  EXPECT_EQ(error_of("name: a\ncolour: red\n"),
            "recording.yaml:2: unknown key 'colour'; expected one of: name, cameras, stamp, exposure, scene, textures");
  EXPECT_EQ(error_of("textures:\n  density: 100\n  densty: 5\n"),
            "recording.yaml:3: unknown key 'densty' in textures; expected one of: density, max_texels, initial");
  const struct {
    const char *text, *message;
  } cases[] = {
      {"scene: {mesh: a.obj}", "unknown key 'mesh' in scene; expected one of: model, scale"},
      {"name: a\nname: b", "recording.yaml:2: key 'name' is there twice"},
      {"? [a]\n: b", "unknown key"},
      {"name: \"\\\x01\"", "is not valid YAML: unknown escape character: ?"},
      {"name: \"a\\nb\"", "name: holds line ends or other control characters"},
      {"cameras: [\"a\\tb\"]", "cameras: holds line ends"},
      {"name: [a]", "name: expected a text"},
      {"cameras: left", "cameras: expected a list"},
      {"cameras: []", "cameras: is empty"},
      {"cameras: [[left]]", "cameras: expected a list of words"},
      {"cameras: [left, left]", "'left' is there twice"},
      {"cameras: [../left]", "'../left' cannot be the name of a sub-directory"},
      {"cameras: [..]", "cannot be the name"},
      {"cameras: [a/b]", "cannot be the name"},
      {"cameras: ['']", "cannot be the name"},
      {"stamp: end", "stamp: is 'end'; expected start_of_exposure or middle_of_exposure"},
      {"stamp: start_of_exposure", "needs to know the exposure"},
      {"exposure: long", "exposure: 'long' is no duration"},
      {"exposure: -1ms", "exposure: is -1ms; expected 0 to 60 s"},
      {"exposure: 1e300", "exposure"},
      {"scene: scene.obj", "scene: expected a map"},
      {"scene: {model: /etc/passwd}", "scene.model: '/etc/passwd' leads out of the recording"},
      {"scene: {model: ../x.obj}", "leads out of the recording"},
      {"scene: {scale: 0}", "scene.scale: is 0; expected"},
      {"scene: {scale: nan}", "scene.scale: is nan; expected"},
      {"scene: {scale: big}", "scene.scale: expected a number, not 'big'"},
      {"scene: {merge: maybe}", "scene.merge: expected true or false, not 'maybe'"},
      {"textures: {max_texels: 1.5}", "textures.max_texels: expected a whole number"},
      {"textures: {max_texels: 1e9}", "textures.max_texels: is 1e9; expected 1 to 16384"},
      {"textures: {density: -1}", "textures.density: is -1"},
      {"textures: {initial: ../t}", "leads out of the recording"},
      {"a: &a [*a]", "unknown key 'a'"},
      {"name: *nothing", "not valid YAML"},
      {"name: \"open", "not valid YAML"},
      {"- a", "expected lines 'key: value'"},
  };
  for (const auto& c : cases) {
    const std::string message = error_of(c.text);
    EXPECT_NE(message.find(c.message), std::string::npos) << c.text << " gives: " << message;
    EXPECT_EQ(message.find("recording.yaml"), 0U) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace foreview
