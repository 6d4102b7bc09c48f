#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "foreview/recordings/builtin.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/progress.h"

namespace foreview {
namespace {

struct GenerateCommand {
  GenerateOptions options;
  std::size_t pictures = 0;
  std::filesystem::path out, json;

  void run();
  [[nodiscard]] std::string report(const std::filesystem::path& directory) const;
};

void GenerateCommand::run() {
  if (pictures > 0) options.pictures = pictures;
  std::unique_ptr<ProgressBar> bar;
  const auto progress = [&](std::size_t done, std::size_t todo) {
    throw_if_interrupted();
    if (!bar) bar = std::make_unique<ProgressBar>("generating " + options.name, todo);
    bar->update(done);
  };
  std::filesystem::path directory = out;
  if (out.empty()) {
    directory = cached_recording(options, progress);
  } else {
    generate_recording(options, directory, progress);
  }
  bar.reset();
  if (!json.empty()) write_file_whole(json, report(directory));
  std::printf("%s\n", directory.string().c_str());
}

std::string GenerateCommand::report(const std::filesystem::path& directory) const {
  const Recording recording = Recording::open(directory);
  nlohmann::ordered_json result;
  result["version"] = 1;
  result["name"] = options.name;
  result["directory"] = directory.string();
  for (const Recording::Camera& camera : recording.cameras()) {
    result["cameras"].push_back({{"name", camera.name},
                                 {"width", camera.model.width},
                                 {"height", camera.model.height},
                                 {"pictures", camera.pictures.size()}});
  }
  const InjectedErrors& e = options.errors;
  result["errors"] = {{"pose_degrees", e.pose_degrees},
                      {"pose_millimetres", e.pose_millimetres},
                      {"focal_length_percent", e.focal_length_percent},
                      {"distortion_percent", e.distortion_percent},
                      {"model_millimetres", e.model_millimetres}};
  return result.dump(2) + "\n";
}

}  // namespace

void add_generate_command(CLI::App& app) {
  CLI::App& command = *app.add_subcommand(
      "generate",
      "Make a built-in recording: a synthetic site, rendered with lens distortion, sensor noise and changing light, of "
      "which the truth is known. Other commands make what they need by themselves; this one is for a copy of one's "
      "own, or for one with errors in what it says about cameras and model.");
  const auto generate = std::make_shared<GenerateCommand>();
  GenerateOptions& options = generate->options;
  std::string names;
  for (const std::string& name : builtin_recording_names()) names += (names.empty() ? "" : ", ") + name;
  command.add_option("NAME", options.name, "Which: " + names)->required();
  command.add_option("--out", generate->out, "Write here (a new or empty directory) instead of into the cache")
      ->type_name("DIR");
  command.add_option("--pictures", generate->pictures, "Only so many pictures per camera (default: all)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  command.add_option("--first", options.first_picture, "Begin with this picture (default: 0)")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--scale", options.scale, "Pictures this much larger or smaller (default: 1, 751x570)")
      ->type_name("S");
  InjectedErrors& errors = options.errors;
  command
      .add_option("--pose-error", errors.pose_degrees,
                  "Record a pan axis that is off by this: every camera turned about the vertical")
      ->type_name("DEG");
  command.add_option("--pose-error-mm", errors.pose_millimetres, "Move every recorded camera pose by this")
      ->type_name("MM");
  command.add_option("--focal-error", errors.focal_length_percent, "Record a focal length too long by this")
      ->type_name("PERCENT");
  command.add_option("--distortion-error", errors.distortion_percent, "Record lens distortion too strong by this")
      ->type_name("PERCENT");
  command.add_option("--model-error", errors.model_millimetres, "Displace each object in the recorded model by this")
      ->type_name("MM");
  command.add_option("--json", generate->json, "Write what was made to this file")->type_name("FILE");
  command.footer("Example: foreview generate workcell --pose-error 1 --out workcell-1deg");
  command.callback([generate] { generate->run(); });
}

}  // namespace foreview
