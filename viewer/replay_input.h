#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>

#include "foreview/recordings/recording.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/replayer.h"

namespace foreview {

/// A directory, or else a built-in recording by its name, which is generated first where it is not cached, with a
/// progress bar. Throws InputError where it is neither.
[[nodiscard]] Recording open_recording(const std::filesystem::path& place);

/// A model's file, with what the import has to say logged.
[[nodiscard]] PolygonModel import_scene(const std::filesystem::path& file, const ImportOptions& options);
/// How fine textures are that no recording proposes anything for; needs a current GL context, for its limits.
[[nodiscard]] ChartOptions chart_options_for(const ReplayOptions& options, const PolygonModel& model);

/// A scene as `options` ask for it, beginning with the textures that they name, else with `initial_textures`. With a
/// debug context where the environment asks for one.
[[nodiscard]] LiveScene::Options live_scene_options(const ReplayOptions& options, const ChartOptions& charts,
                                                    const std::optional<std::filesystem::path>& initial_textures);

/// Recording, model and chart options that ReplayOptions name: made in this order, since each needs the one before.
struct ReplayInput {
  /// Opens the recording (a directory wins over a built-in one of the same name, which is generated first where it is
  /// not cached, with a progress bar) and imports the model. Needs a current GL context, for its limits. Throws
  /// InputError where the recording, its model or the options cannot be used.
  explicit ReplayInput(const ReplayOptions& from);
  ReplayOptions options;
  Recording recording;
  std::size_t camera;  ///< index of the operator's camera
  PolygonModel model;
  ChartOptions charts;
};

/// --from and --to, cut to where the state of everything is known.
struct ReplaySpan {
  Timestamp first, last;
};
/// Throws InputError where no picture with its state lies within them, or they are no positions.
[[nodiscard]] ReplaySpan find_span(const ReplayInput& input);

}  // namespace foreview
