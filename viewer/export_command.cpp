#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/progress.h"
#include "foreview/viewer/replay_options_cli.h"
#include "foreview/viewer/replayer.h"

namespace foreview {
namespace {

struct ExportCommand {
  std::filesystem::path file;
  ReplayOptions replay;
  bool with_backdrop = false;
  std::filesystem::path json_file;
};

/// Before the long work, not after it.
void check_output(const std::filesystem::path& file, const char* extension) {
  if (file.extension() != extension) {
    throw InputError(file.string(),
                     std::string("is no name for the file to write; expected one that ends in ") + extension);
  }
  const std::filesystem::path directory = file.has_parent_path() ? file.parent_path() : ".";
  if (!std::filesystem::is_directory(directory)) {
    throw InputError(file.string(), "cannot be written: there is no directory " + directory.string());
  }
}

void run(const ExportCommand& command) {
  check_output(command.file, ".glb");
  if (!command.json_file.empty()) check_output(command.json_file, ".json");
  const GlDebug debug = gl_debug_from_environment();
  OffscreenContext::Options context_options;
  context_options.debug = debug != GlDebug::off;
  const OffscreenContext context(context_options);
  if (debug != GlDebug::off) install_debug_callback(debug == GlDebug::fatal);

  Replayer replayer(command.replay);
  const Timestamp end = replayer.last();
  {
    std::unique_ptr<ProgressBar> bar;
    // Pictures are used if captured before this time, and the last one of the range is meant to be used too.
    const std::size_t done = replayer.advance_to(end + Duration{1}, [&](std::size_t number, std::size_t todo) {
      throw_if_interrupted();
      if (!bar) bar = std::make_unique<ProgressBar>("extracting textures", todo);
      bar->update(number);
    });
    if (bar) bar->update(done);
  }
  replayer.save_textures_if_asked();
  const std::optional<PredictedState> state = replayer.predicted_state(end);
  if (!state) throw InputError(command.replay.recording.string(), "where its parts are is not recorded at the end");
  const TextureStore& store = replayer.store();
  export_glb(store, state->world_from_part, command.file, command.with_backdrop);

  const auto states = store.read_polygon_states();
  std::size_t polygons = 0, seen = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (store.model().polygons()[i].is_backdrop && !command.with_backdrop) continue;
    ++polygons;
    if (states[i].seen == 1.0F) ++seen;
  }
  const std::uintmax_t bytes = std::filesystem::file_size(command.file);
  std::printf("%s: %.1f MB, %zu polygons in %zu parts, %zu of them seen in %zu pictures\n", command.file.c_str(),
              static_cast<double>(bytes) * 1e-6, polygons, store.model().parts().size(), seen,
              replayer.pictures_extracted());
  if (command.replay.stats) std::fputs(counters_text(replayer.counters()).c_str(), stdout);
  if (!command.json_file.empty()) {
    const nlohmann::json json{{"version", 1},
                              {"recording", command.replay.recording.string()},
                              {"file", command.file.string()},
                              {"bytes", bytes},
                              {"polygons", polygons},
                              {"polygons_seen", seen},
                              {"parts", store.model().parts().size()},
                              {"pages", store.layout().pages},
                              {"page_size", store.layout().page_size},
                              {"pictures", replayer.pictures_extracted()}};
    // Names come from the command line, and need not be UTF-8.
    write_file_whole(command.json_file, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  }
}

}  // namespace

void add_export_command(CLI::App& app) {
  auto command = std::make_shared<ExportCommand>();
  command->replay.delay = Duration{0};
  CLI::App* sub = app.add_subcommand("export", "Write the model with the textures of a recording as binary glTF");
  sub->add_option("OUT", command->file, "The file to write, NAME.glb")->required();
  add_replay_options(*sub, command->replay);
  add_registration_option(*sub, command->replay);
  add_pipeline_options(*sub, command->replay);
  sub->add_flag("--backdrop", command->with_backdrop, "With the box around the scene that shows what is far away");
  sub->add_option("--json", command->json_file, "Write what was exported to this file")->type_name("FILE.json");
  sub->footer(
      "The textures are those after the last picture up to --to; moving parts stand where they were then. Unlike\n"
      "elsewhere, --delay is 0 unless given.\n"
      "Example: foreview export workcell.glb workcell --to 5s");
  sub->callback([command] { run(*command); });
}

}  // namespace foreview
