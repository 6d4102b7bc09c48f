#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/evaluation.h"
#include "foreview/viewer/evaluation_report.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/progress.h"
#include "foreview/viewer/replay_options_cli.h"

namespace foreview {
namespace {

struct EvaluateCommand {
  EvaluationOptions options;
  std::filesystem::path json;

  void run() const {
    // Found out at the end, it would cost the whole run.
    const std::filesystem::path folder = json.parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder)) {
      throw InputError("--json", "no such directory: " + folder.string());
    }
    const GlDebug debug = gl_debug_from_environment();
    OffscreenContext::Options context_options;
    context_options.debug = debug != GlDebug::off;
    OffscreenContext context(context_options);
    context.make_current();
    if (debug != GlDebug::off) install_debug_callback(debug == GlDebug::fatal);

    Replayer replayer(options.replay);
    Evaluation evaluation;
    {
      std::unique_ptr<ProgressBar> bar;
      evaluation = evaluate(replayer, options, [&](std::size_t done, std::size_t todo) {
        throw_if_interrupted();
        if (!bar) bar = std::make_unique<ProgressBar>("evaluating", todo);
        bar->update(done);
      });
    }
    std::fputs(evaluation_table(evaluation, options).c_str(), stdout);
    if (options.replay.stats) std::fputs(counters_text(replayer.counters()).c_str(), stdout);
    std::fflush(stdout);
    if (!json.empty()) write_file_whole(json, evaluation_json(evaluation, options));
    // Half a run's textures would pass for those of the whole.
    if (!evaluation.complete) throw Interrupted();
    replayer.save_textures_if_asked();
  }
};

}  // namespace

void add_evaluate_command(CLI::App& app) {
  CLI::App& command = *app.add_subcommand(
      "evaluate",
      "How good is the prediction on a recording? At every N-th picture's time, the predicted view, the delayed "
      "picture "
      "as it is and the delayed picture warped by the camera's rotation are compared with the true picture: PSNR and "
      "SSIM, how much of the view has been seen, and the error beyond silhouettes, where ghosts appear.");
  const auto evaluate = std::make_shared<EvaluateCommand>();
  add_replay_options(command, evaluate->options.replay);
  add_registration_option(command, evaluate->options.replay);
  add_pipeline_options(command, evaluate->options.replay);
  command
      .add_option_function<std::string>(
          "--every", [evaluate](const std::string& text) { evaluate->options.every = parse_count(text, "--every"); },
          "Evaluate every N-th of the operator's pictures (default: 1)")
      ->type_name("N");
  command
      .add_option_function<std::string>(
          "--images", [evaluate](const std::string& text) { evaluate->options.images = text; },
          "Write predicted/, delayed/, rotation/ and truth/ as PNG here, named like the pictures, undistorted")
      ->type_name("DIR");
  command
      .add_option_function<std::string>(
          "--json", [evaluate](const std::string& text) { evaluate->json = text; },
          "Write all figures, of every instant too, to this file")
      ->type_name("FILE");
  command.footer("Example: foreview evaluate workcell --delay 500ms --every 10 --json workcell.json");
  command.callback([evaluate] { evaluate->run(); });
}

}  // namespace foreview
