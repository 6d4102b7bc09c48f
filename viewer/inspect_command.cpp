#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <memory>

#include "foreview/scene/errors.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/model_inspection.h"

namespace foreview {
namespace {

struct InspectArguments {
  std::string model, json;
  ImportOptions import_options;
  ChartOptions chart_options;
  bool no_merge = false, no_backdrop = false;
};

void inspect(InspectArguments& arguments) {
  arguments.import_options.merge_coplanar = !arguments.no_merge;
  arguments.import_options.backdrop = !arguments.no_backdrop;
  const ModelInspection inspection = inspect_model(arguments.model, arguments.import_options, arguments.chart_options);
  std::fputs(to_text(inspection).c_str(), stdout);
  if (arguments.json.empty()) return;
  std::ofstream stream(arguments.json, std::ios::binary);
  stream << to_json(inspection);
  if (!stream.flush())
    throw InputError(arguments.json, "cannot be written; is the directory there, and the disk not full?");
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("inspect", "Report what the importer makes of a model, and what looks wrong with it");
  const auto arguments = std::make_shared<InspectArguments>();
  command->add_option("MODEL", arguments->model, "Model file: OBJ, PLY, STL, OFF, glTF/GLB, DAE")
      ->required()
      ->type_name("");
  command->add_option("--scale", arguments->import_options.scale, "Metres per unit of the file")
      ->type_name("METRES")
      ->capture_default_str();
  command->add_option("--density", arguments->chart_options.texels_per_metre, "Texels per metre")
      ->type_name("TEXELS")
      ->capture_default_str();
  command->add_option("--max-texels", arguments->chart_options.max_texels, "Most texels of one polygon along an axis")
      ->type_name("TEXELS")
      ->capture_default_str();
  command->add_flag("--no-merge", arguments->no_merge, "Keep coplanar neighbours apart");
  command->add_flag("--no-backdrop", arguments->no_backdrop, "Put no far box around the scene");
  command->add_option("--json", arguments->json, "Write the same figures to this file, for programs")
      ->type_name("FILE");
  command->footer("Example: foreview inspect cell.stl --scale 0.001 --density 200");
  command->callback([arguments] { inspect(*arguments); });
}

}  // namespace foreview
