#pragma once
#include <optional>
#include <string>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// What recording.yaml says (docs/recording-format.md); everything has a default.
struct RecordingYaml {
  std::string name;
  std::vector<std::string> cameras;  ///< sub-directories; empty: one camera, its files at the top
  StampMeaning stamp_meaning = StampMeaning::middle_of_exposure;
  Duration exposure;
  std::optional<std::string> scene_file;  ///< relative
  ImportOptions import_options;
  std::optional<double> density;
  std::optional<int> max_texels;
  std::optional<std::string> initial_textures;  ///< relative; what save_textures() wrote
};

/// Throws InputError "WHERE:LINE: KEY: why" on unknown keys, wrong types and impossible values.
[[nodiscard]] RecordingYaml parse_recording_yaml(const std::string& text, const std::string& where);
[[nodiscard]] std::string to_recording_yaml(const RecordingYaml& recording);

/// Can this be the name of a camera's directory or a part's file? Neither empty nor hidden, without separators or
/// control characters.
[[nodiscard]] bool is_plain_file_name(const std::string& name);

}  // namespace foreview
